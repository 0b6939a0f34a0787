#include "armukf/core/sealed.hpp"

#include <fmt/format.h>

#include <boost/crc.hpp>
#include <cstddef>

#include "armukf/core/archive.hpp"
#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr std::size_t kHeader = 24;   // bytes
constexpr std::size_t kChecked = 16;  // bytes before what the checksum is of

std::uint32_t checksum(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace

std::string sealed(const Seal& seal, std::string_view content) {
  OutArchive length;
  std::uint64_t size = content.size();
  length(size);
  const std::string body = length.bytes() + std::string(content);
  OutArchive header;
  std::uint32_t version = seal.version;
  std::uint32_t sum = checksum(body);
  header(version, sum);
  return std::string(seal.magic) + header.bytes() + body;
}

std::string_view unsealed(const Seal& seal, std::string_view bytes) {
  const std::size_t known = std::min(bytes.size(), seal.magic.size());
  constexpr std::string_view kOurs = "armukf_";
  if (bytes.size() > kOurs.size() && bytes.starts_with(kOurs) &&
      bytes[kOurs.size()] != seal.magic[kOurs.size()])
    throw InputError(
        "is a checkpoint of armukf, but of another kind: with --key it is one of many arms");
  if (bytes.substr(0, known) != seal.magic.substr(0, known) || bytes.empty())
    throw InputError("is no checkpoint of armukf");
  if (bytes.size() < kHeader) throw InputError(fmt::format("is cut short: {} bytes", bytes.size()));
  InArchive header(bytes.substr(seal.magic.size()));
  std::uint32_t version = 0;
  std::uint32_t sum = 0;
  std::uint64_t size = 0;
  header(version, sum, size);
  if (version != seal.version)
    throw InputError(
        fmt::format("is of version {}; this program knows version {}", version, seal.version));
  if (header.left() < size)
    throw InputError(fmt::format("is cut short: {} bytes of {}", bytes.size(), kHeader + size));
  if (header.left() > size || checksum(bytes.substr(kChecked)) != sum)
    throw InputError("is damaged: its checksum is wrong");
  return bytes.substr(kHeader);
}

}  // namespace armukf
