#pragma once

#include <CLI/CLI.hpp>

/// One function per subcommand: adds its options to the program's, and does its work once they are
/// read. What is wrong with the user's input leaves it as an InputError.
namespace armukf::apps {

void add_compare(CLI::App& program);
void add_diagnose(CLI::App& program);
void add_estimate(CLI::App& program);
void add_evaluate(CLI::App& program);
void add_export(CLI::App& program);
void add_fit(CLI::App& program);
void add_simulate(CLI::App& program);
void add_smooth(CLI::App& program);

}  // namespace armukf::apps
