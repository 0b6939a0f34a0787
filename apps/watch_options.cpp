#include "watch_options.hpp"

#include "armukf/core/error.hpp"
#include "signals.hpp"

namespace armukf::apps {

void add_watch_options(CLI::App& command, WatchOptions& options) {
  command.add_flag("--watch", options.watch,
                   "look for changes of the machine; what has changed follows, all else "
                   "stays.\nRows have a column `event` more: what was said to have changed");
  command
      .add_option("--events", options.events,
                  "with --watch: a line of JSON for each change, and one more when its size has "
                  "settled;\n- is standard output, which then has no rows")
      ->type_name("FILE");
}

void check_watch_options(const WatchOptions& options) {
  if (!options.events.empty() && !options.watch) throw InputError("--events: needs --watch");
}

EventLog::EventLog(const std::string& path) {
  if (!path.empty()) output_.emplace(path, stop_flag());
}

void EventLog::put(std::string_view lines) {
  if (!output_ || lines.empty()) return;
  output_->append_rows(lines);
  output_->flush();
}

}  // namespace armukf::apps
