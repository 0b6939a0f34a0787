#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/core/error.hpp"

namespace armukf::apps {

/// The finite number that the whole text says; InputError, `'abc' is not a number`, otherwise.
double number_in(std::string_view text);

/// Checks of an option's text, to be attached to it: a finite number from a bound on, above it, or
/// up to it.
CLI::Validator number_from(double least);
CLI::Validator number_above(double bound);
CLI::Validator number_to(double greatest);

/// A whole number from `least` to `greatest`.
CLI::Validator whole_number(std::uint64_t least, std::uint64_t greatest);

/// One of these words, which the help shows.
CLI::Validator one_of(const std::vector<std::string>& words);

/// That word, or a whole number from least to greatest.
CLI::Validator word_or_whole_number(const std::string& word, std::uint64_t least,
                                    std::uint64_t greatest);

/// How many threads share the work.
void add_threads_option(CLI::App& command, int& threads);

/// The result of an action; an InputError of it gets the option's name before it.
template <class Action>
auto of_option(std::string_view option, const Action& action) {
  try {
    return action();
  } catch (const InputError& error) {
    throw InputError(option, 0, "", error.what());
  }
}

}  // namespace armukf::apps
