#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "armukf/batch/simulation.hpp"

namespace armukf::apps {

/// What the options say about the states at a record's first sample.
struct InitialOptions {
  std::vector<std::string> free;   // names, or one of "all" and "none"; empty: the default
  std::vector<std::string> given;  // NAME=VALUE

  bool frees_none() const;
};

void add_initial_options(CLI::App& command, InitialOptions& options);

/// The choice they make among the model's states, or `otherwise` where they name no free ones.
InitialChoice chosen_initial(const InitialOptions& options, const Model& model,
                             const InitialChoice& otherwise);

}  // namespace armukf::apps
