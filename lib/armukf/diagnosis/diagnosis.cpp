#include "armukf/diagnosis/diagnosis.hpp"

#include <array>

namespace armukf {

std::string_view name_of(Verdict verdict) {
  constexpr std::array<std::string_view, 3> kNames{"model sufficient", "effect found",
                                                   "residual unexplained"};
  return kNames[static_cast<int>(verdict)];
}

}  // namespace armukf
