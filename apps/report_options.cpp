#include "report_options.hpp"

#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "armukf/io/atomic_file.hpp"

namespace armukf::apps {

void add_report_options(CLI::App& command, ReportOptions& options) {
  command.add_option("--json", options.json, "write a summary; - is standard output")
      ->type_name("FILE");
  command.add_flag("--quiet", options.quiet, "print nothing but what was asked for");
}

void print(std::string_view text) { write_all(STDOUT_FILENO, text, "<stdout>"); }

void write_json(const ReportOptions& options, const nlohmann::ordered_json& json) {
  if (options.json.empty()) return;
  AtomicFile file(options.json);
  file.write(json.dump(2) + "\n");
  file.commit();
}

void write_report(const ReportOptions& options, const std::string& text,
                  const nlohmann::ordered_json& json,
                  std::initializer_list<std::string_view> files) {
  const bool taken = options.json == "-" || std::ranges::find(files, "-") != files.end();
  if (!options.quiet && !taken) print(text);
  write_json(options, json);
}

}  // namespace armukf::apps
