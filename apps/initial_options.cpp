#include "initial_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

#include "armukf/core/error.hpp"
#include "model_options.hpp"
#include "option_values.hpp"

namespace armukf::apps {
namespace {

int state_named(const Model& model, std::string_view name) {
  const auto at = std::ranges::find(model.states, name, &Coordinate::name);
  if (at != model.states.end()) return static_cast<int>(at - model.states.begin());
  std::vector<std::string> names;
  for (const Coordinate& state : model.states) names.push_back(state.name);
  throw InputError(fmt::format("unknown state '{}'; known are: {}", name, fmt::join(names, ", ")));
}

std::vector<int> free_states(const InitialOptions& options, const Model& model) {
  const std::vector<std::string>& names = options.free;
  if (names == std::vector<std::string>{"all"}) return all_free(model).free;
  if (options.frees_none()) return {};
  for (const char* alone : {"all", "none"})
    if (std::ranges::find(names, alone) != names.end())
      throw InputError(fmt::format("{} stands alone", alone));
  std::vector<int> states;
  for (const std::string& name : names) {
    const int state = state_named(model, name);
    if (std::ranges::find(states, state) == states.end()) states.push_back(state);
  }
  return states;
}

void give_value(const std::string& assignment, const Model& model, InitialChoice& choice) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos)
    throw InputError(fmt::format("'{}' is not NAME=VALUE", assignment));
  const int state = state_named(model, assignment.substr(0, equals));
  choice.given[state] = number_in(std::string_view(assignment).substr(equals + 1));
  std::erase(choice.free, state);
}

}  // namespace

bool InitialOptions::frees_none() const { return free == std::vector<std::string>{"none"}; }

void add_initial_options(CLI::App& command, InitialOptions& options) {
  command
      .add_option("--free-initial", options.free,
                  "states that are free at the first sample, comma-separated; all; or none")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAME,...");
  add_repeatable(command, "--initial", options.given,
                 "value of a state at the first sample, which is then not free; repeatable")
      ->type_name("NAME=VALUE");
}

InitialChoice chosen_initial(const InitialOptions& options, const Model& model,
                             const InitialChoice& otherwise) {
  InitialChoice choice = otherwise;
  of_option("--free-initial", [&] {
    if (!options.free.empty()) choice.free = free_states(options, model);
  });
  of_option("--initial", [&] {
    for (const std::string& assignment : options.given) give_value(assignment, model, choice);
  });
  return choice;
}

}  // namespace armukf::apps
