#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "armukf/io/csv_writer.hpp"

namespace armukf::apps {

/// Whether an estimate looks for changes of the machine, and where it writes them.
struct WatchOptions {
  bool watch = false;
  std::string events;  // file; - is standard output; empty: nowhere
};

void add_watch_options(CLI::App& command, WatchOptions& options);

/// InputError where they do not go with the others; `json` is where the summary goes.
void check_watch_options(const WatchOptions& options);

/// Lines about events, each of which reaches its reader at once.
class EventLog {
 public:
  /// goes_on: behind the lines that the file holds. Else they stay until there is something to
  /// watch, since a start may fail.
  EventLog(const std::string& path, bool goes_on);

  /// To be called when there is.
  void begin();

  void put(std::string_view lines);

 private:
  std::string name_;
  Descriptor file_;
  std::optional<CsvWriter> output_;  // empty: nowhere
  bool is_stale_ = false;            // what the file holds
};

}  // namespace armukf::apps
