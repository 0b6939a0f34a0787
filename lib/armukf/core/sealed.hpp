#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace armukf {

/// What is in a seal besides the content.
struct Seal {
  std::string_view magic;  // 8 bytes that tell what it is
  std::uint32_t version;   // of the content's layout
};

/// The content with all that tells later whether it is whole, 24 bytes before it: the magic, the
/// version (32 bits), the CRC-32 (IEEE 802.3) of all that follows, and the content's length (64
/// bits), each little-endian.
std::string sealed(const Seal& seal, std::string_view content);

/// The content again. InputError, saying why, where the bytes are something else, of another
/// version, cut short, or not what was sealed.
std::string_view unsealed(const Seal& seal, std::string_view bytes);

}  // namespace armukf
