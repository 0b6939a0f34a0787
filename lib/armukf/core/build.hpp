#pragma once

#include <string_view>

namespace armukf {

/// The version of the library, and the processor that this build of it was made for: `x86-64-v3`,
/// `native`, `aarch64`. The dynamic loader chooses between several builds of the shared library.
std::string_view library_version();
std::string_view build_processor();

}  // namespace armukf
