#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace armukf::apps {

/// What to do about a row that cannot be read.
enum class OnError { kStop, kSkip, kMissing };

/// How a stream of rows is taken in, and how an estimate of it outlives the program.
struct StreamOptions {
  std::string on_error;    // stop, skip, missing; empty: stop for a file, skip for what is live
  double reorder_s = 0.0;  // s
  bool follow = false;
  std::string checkpoint;  // file; empty: none
  double every_s = 10.0;   // s
  std::string resume;
  bool new_clock = false;
};

void add_stream_options(CLI::App& command, StreamOptions& options);

/// InputError where they do not go together.
void check_stream_options(const StreamOptions& options, const std::string& input);

}  // namespace armukf::apps
