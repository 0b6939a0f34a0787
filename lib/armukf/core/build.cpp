#include "armukf/core/build.hpp"

namespace armukf {

// Both are set by the build, the second for each build of the library.
std::string_view library_version() { return ARMUKF_VERSION; }
std::string_view build_processor() { return ARMUKF_PROCESSOR; }

}  // namespace armukf
