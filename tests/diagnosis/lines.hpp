#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace armukf {

/// Whether what is told has a line with that text.
inline bool any_has(const std::vector<std::string>& lines, std::string_view text) {
  return std::ranges::any_of(
      lines, [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

}  // namespace armukf
