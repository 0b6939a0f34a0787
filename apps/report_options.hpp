#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace armukf::apps {

/// The options that say where results go, and how much is said beside them.
struct ReportOptions {
  std::string json;  // file, "-" for standard output; empty: none
  bool quiet = false;
};

void add_report_options(CLI::App& command, ReportOptions& options);

/// The JSON to its file, if one was asked for; the file takes its name only when complete.
void write_json(const ReportOptions& options, const nlohmann::ordered_json& json);

/// The text to standard output unless that was asked to be quiet or holds the JSON; then the JSON.
void write_report(const ReportOptions& options, const std::string& text,
                  const nlohmann::ordered_json& json);

}  // namespace armukf::apps
