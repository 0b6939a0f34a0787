#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace armukf::apps {

/// The options that say where results go, and how much is said beside them.
struct ReportOptions {
  std::string json;  // file, "-" for standard output; empty: none
  bool quiet = false;
};

void add_report_options(CLI::App& command, ReportOptions& options);

/// The text to standard output, at once; a failure to do so is not lost as it would be at the end
/// of the program. A reader that has left is no failure.
void print(std::string_view text);

/// The JSON to its file, if one was asked for; the file takes its name only when complete.
void write_json(const ReportOptions& options, const nlohmann::ordered_json& json);

/// The text to standard output unless that was asked to be quiet or holds the JSON or another of
/// the command's files; then the JSON.
void write_report(const ReportOptions& options, const std::string& text,
                  const nlohmann::ordered_json& json,
                  std::initializer_list<std::string_view> files = {});

}  // namespace armukf::apps
