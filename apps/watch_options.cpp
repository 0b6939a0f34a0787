#include "watch_options.hpp"

#include <utility>

#include "armukf/core/error.hpp"
#include "armukf/io/atomic_file.hpp"
#include "signals.hpp"

namespace armukf::apps {

void add_watch_options(CLI::App& command, WatchOptions& options) {
  command.add_flag("--watch", options.watch,
                   "look for changes of the machine; what has changed follows, all else "
                   "stays.\nRows have a column `event` more: what was said to have changed");
  command
      .add_option("--events", options.events,
                  "with --watch: a line of JSON for each change, and one more when its size has "
                  "settled;\nwith --resume behind those that are there; - is standard output, "
                  "which then has no rows")
      ->type_name("FILE");
}

void check_watch_options(const WatchOptions& options) {
  if (!options.events.empty() && !options.watch) throw InputError("--events: needs --watch");
}

EventLog::EventLog(const std::string& path, bool goes_on) : name_(shown_name(path)) {
  if (path.empty()) return;
  file_ = open_for_appending(path);
  output_.emplace(file_.number(), name_, stop_flag());
  is_stale_ = path != "-" && !goes_on;
}

void EventLog::begin() {
  if (std::exchange(is_stale_, false)) make_empty(file_.number(), name_);
}

void EventLog::put(std::string_view lines) {
  if (!output_ || lines.empty()) return;
  output_->append_rows(lines);
  output_->flush();
}

}  // namespace armukf::apps
