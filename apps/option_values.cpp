#include "option_values.hpp"

#include <fmt/format.h>

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

/// A check that passes, with an empty message, where `fault` finds nothing to say.
CLI::Validator check(const std::function<std::string(double)>& fault, const std::string& kind) {
  const auto complaint = [fault](const std::string& text) -> std::string {
    try {
      return fault(number_in(text));
    } catch (const InputError& error) {
      return error.what();
    }
  };
  return {complaint, kind};
}

}  // namespace

double number_in(std::string_view text) {
  double value = 0.0;
  if (!read_whole(text, value)) throw InputError(fmt::format("'{}' is not a number", text));
  if (!std::isfinite(value)) throw InputError(fmt::format("must be finite, not {}", text));
  return value;
}

CLI::Validator number_from(double least) {
  return check(
      [least](double value) {
        return value >= least ? "" : fmt::format("must be at least {}, not {}", least, value);
      },
      "NUMBER");
}

CLI::Validator number_above(double least) {
  return check(
      [least](double value) {
        return value > least ? "" : fmt::format("must be above {}, not {}", least, value);
      },
      "NUMBER");
}

CLI::Validator whole_number(std::uint64_t least, std::uint64_t greatest) {
  const auto complaint = [least, greatest](const std::string& text) -> std::string {
    std::uint64_t value = 0;
    if (read_whole(text, value) && value >= least && value <= greatest) return {};
    return fmt::format("must be a whole number from {} to {}, not '{}'", least, greatest, text);
  };
  return {complaint, "NUMBER"};
}

}  // namespace armukf::apps
