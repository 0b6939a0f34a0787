#include "stream_options.hpp"

#include "armukf/core/error.hpp"
#include "option_values.hpp"

namespace armukf::apps {

void add_stream_options(CLI::App& command, StreamOptions& options) {
  command
      .add_option("--on-error", options.on_error,
                  "at a row that cannot be read: stop (the default for a file), skip it (for what "
                  "is live), or take its measurement for missing if its time can be read")
      ->check(one_of({"stop", "skip", "missing"}));
  command
      .add_option("--reorder-s", options.reorder_s,
                  "s by which a row may come later than those after it; rows wait so long")
      ->check(number_from(0.0));
  command.add_flag("--follow", options.follow,
                   "FILE is still written: wait for more, and go on with a new file of that name");
  CLI::Option* checkpoint =
      command
          .add_option("--checkpoint", options.checkpoint,
                      "write what is needed to go on after the program has died")
          ->type_name("FILE");
  command
      .add_option("--every-s", options.every_s,
                  "s between two checkpoints, 10 by default; one more "
                  "at the end")
      ->check(number_above(0.0))
      ->needs(checkpoint);
  command
      .add_option("--resume", options.resume,
                  "go on from a checkpoint; rows up to its time are passed over")
      ->type_name("FILE");
  command.add_flag("--new-clock", options.new_clock,
                   "with --resume: the rows' clock was set meanwhile, pass over none");
}

void check_stream_options(const StreamOptions& options, const std::string& input) {
  if (options.follow && input == "-") throw InputError("--follow: needs a FILE");
  if (options.checkpoint == "-") throw InputError("--checkpoint: needs a FILE to replace");
  if (options.new_clock && options.resume.empty()) throw InputError("--new-clock: needs --resume");
}

}  // namespace armukf::apps
