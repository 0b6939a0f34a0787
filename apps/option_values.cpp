#include "option_values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <system_error>

namespace armukf::apps {
namespace {

/// The number that is all of the text, in the type's range.
template <class Number>
bool read_whole(std::string_view text, Number& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

bool is_whole_number(std::string_view text, std::uint64_t least, std::uint64_t greatest) {
  std::uint64_t value = 0;
  return read_whole(text, value) && value >= least && value <= greatest;
}

/// A check that the number of an option's text passes; `wanted` completes "must be".
CLI::Validator check(const std::function<bool(double)>& passes, const std::string& wanted) {
  const auto complaint = [passes, wanted](const std::string& text) -> std::string {
    try {
      return passes(number_in(text)) ? "" : fmt::format("must be {}, not {}", wanted, text);
    } catch (const InputError& error) {
      return error.what();
    }
  };
  return {complaint, ""};
}

}  // namespace

double number_in(std::string_view text) {
  double value = 0.0;
  if (!read_whole(text, value)) throw InputError(fmt::format("'{}' is not a number", text));
  if (!std::isfinite(value)) throw InputError(fmt::format("must be finite, not {}", text));
  return value;
}

CLI::Validator number_from(double least) {
  return check([least](double value) { return value >= least; }, fmt::format("at least {}", least));
}

CLI::Validator number_above(double bound) {
  return check([bound](double value) { return value > bound; }, fmt::format("above {}", bound));
}

CLI::Validator number_to(double greatest) {
  return check([greatest](double value) { return value <= greatest; },
               fmt::format("at most {}", greatest));
}

CLI::Validator whole_number(std::uint64_t least, std::uint64_t greatest) {
  const auto complaint = [least, greatest](const std::string& text) -> std::string {
    if (is_whole_number(text, least, greatest)) return {};
    return fmt::format("must be a whole number from {} to {}, not '{}'", least, greatest, text);
  };
  return {complaint, ""};
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  const auto complaint = [words](const std::string& text) -> std::string {
    if (std::ranges::find(words, text) != words.end()) return {};
    return fmt::format("must be one of {}, not '{}'", fmt::join(words, ", "), text);
  };
  return {complaint, fmt::format("{{{}}}", fmt::join(words, ","))};
}

CLI::Validator word_or_whole_number(const std::string& word, std::uint64_t least,
                                    std::uint64_t greatest) {
  const auto complaint = [=](const std::string& text) -> std::string {
    if (text == word || is_whole_number(text, least, greatest)) return {};
    return fmt::format("must be {} or a whole number from {} to {}, not '{}'", word, least,
                       greatest, text);
  };
  return {complaint, ""};
}

void add_threads_option(CLI::App& command, int& threads) {
  constexpr int kMost = 1024;
  command
      .add_option("--threads", threads,
                  "that share the work (default: one per processor); results do not depend on it")
      ->check(whole_number(1, kMost));
}

}  // namespace armukf::apps
