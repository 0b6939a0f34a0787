#include "armukf/core/error.hpp"

#include <fmt/format.h>

namespace armukf {
namespace {

std::string message(std::string_view place, std::size_t line, std::string_view column,
                    std::string_view what) {
  std::string text(place);
  if (line != 0) text += fmt::format(":{}", line);
  text += ": ";
  if (!column.empty()) text += fmt::format("{}: ", column);
  return text.append(what);
}

}  // namespace

InputError::InputError(std::string_view place, std::size_t line, std::string_view column,
                       std::string_view what)
    : std::runtime_error(message(place, line, column, what)) {}

}  // namespace armukf
