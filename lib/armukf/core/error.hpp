#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace armukf {

/// The user gave us something wrong. The message is one line, `FILE:LINE: COLUMN: what is wrong`;
/// `main` alone catches it, prints it and returns 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& what) : std::runtime_error(what) {}

  /// A fault at a place: `place:line: column: what`. Line 0 and an empty column are left out.
  InputError(std::string_view place, std::size_t line, std::string_view column,
             std::string_view what);
};

}  // namespace armukf
