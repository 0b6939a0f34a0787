#include "armukf/core/error.hpp"

#include <fmt/format.h>

namespace armukf {
namespace {

std::string message(std::string_view place, std::size_t line, std::string_view column,
                    std::string_view what) {
  const std::string where = line == 0 ? std::string(place) : fmt::format("{}:{}", place, line);
  return column.empty() ? fmt::format("{}: {}", where, what)
                        : fmt::format("{}: {}: {}", where, column, what);
}

}  // namespace

InputError::InputError(std::string_view place, std::size_t line, std::string_view column,
                       std::string_view what)
    : std::runtime_error(message(place, line, column, what)) {}

}  // namespace armukf
