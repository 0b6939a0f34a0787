#include <cstddef>
#include <cstdint>

#include "fuzz/targets.hpp"

/// libFuzzer's; ARMUKF_FUZZED is the target of this program.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  armukf::fuzz::ARMUKF_FUZZED({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
