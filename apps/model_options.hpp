#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "armukf/io/csv_reader.hpp"
#include "armukf/report/model_file.hpp"

namespace armukf::apps {

/// What the options say that choose a model: --model, --effect, --set, --free, --fix.
struct ModelOptions {
  std::string file;                  // empty: none
  std::vector<std::string> effects;  // names
  std::vector<std::string> values;   // NAME=VALUE
  std::vector<std::string> free;     // names
  std::vector<std::string> fixed;    // names
};

void add_model_options(CLI::App& command, ModelOptions& options);
void add_columns_option(CLI::App& command, Columns& columns);
void add_filter_option(CLI::App& command, std::string& filter,
                       const std::vector<std::string>& names = filter_names());

/// An option that may be repeated and takes one value each time: no file name after it is lost.
CLI::Option* add_repeatable(CLI::App& command, const std::string& names,
                            std::vector<std::string>& values, const std::string& description);

/// The model file over the built-in defaults, or `otherwise` where there is none; then the effects,
/// then values and what is unknown. InputError, with the option's name before it, where they do not
/// fit together.
ModelFile chosen_model(const ModelOptions& options, const ModelFile& otherwise = {});

/// The filter of that name, if one is named. InputError lists those there are.
void choose_filter(EstimatorSettings& settings, const std::string& name);

/// Deviations that an earlier estimate has told count so many times, if the model file has any; but
/// nothing counts as less sure than at the start of an estimate from scratch, and where that is so
/// of most parameters, all is forgotten but the values.
void forget(ModelFile& file, double factor);

}  // namespace armukf::apps
