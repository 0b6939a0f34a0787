#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/report/model_file.hpp"
#include "model_options.hpp"

namespace armukf::apps {

/// Where start values come from, beside the model: `--start slow SLOW.csv`, `--start frequency`.
struct StartOptions {
  std::string slow_file;  // empty: not asked for
  bool frequency = false;

  bool any() const { return frequency || !slow_file.empty(); }
};

void add_start_options(CLI::App& command, StartOptions& options);

/// The words that a user typed, with `--start slow FILE` as `--start slow=FILE`: an option that
/// takes one word or two would swallow the file after it.
std::vector<std::string> with_joined_starts(const std::vector<std::string>& words);

/// Finds the model's start values in these ways, first `slow`, then `frequency` in the record that
/// is to be estimated. What the user gave by --set stays. Returns what was found, as text for a
/// person.
std::string find_start(const StartOptions& options, const ModelOptions& model_options,
                       const Record& record, const Columns& columns, ModelFile& start);

}  // namespace armukf::apps
