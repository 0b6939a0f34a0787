#include "armukf/core/error.hpp"

#include <fmt/format.h>

namespace armukf {

InputError::InputError(std::string_view place, std::size_t line, std::string_view column,
                       std::string_view what)
    : std::runtime_error(fmt::format("{}{}: {}{}{}", place,
                                     line == 0 ? std::string() : fmt::format(":{}", line), column,
                                     column.empty() ? "" : ": ", what)) {}

}  // namespace armukf
