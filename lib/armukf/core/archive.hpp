#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/core/lanes.hpp"

/// Objects as bytes, and back. A class lists what it holds once, for both ways:
///
///     template <class Archive>
///     void archive(Archive& archive) { archive(mean_, covariance_); }
///
/// A number stands as it does in memory (little-endian), whatever has a length has that before it
/// as 64 bits, and an optional one a byte that says whether it is there. Of lanes only those in use
/// are kept, so that the bytes do not depend on the width of a register.
namespace armukf {

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Collects bytes. What is given is only read.
class OutArchive {
 public:
  static constexpr bool kLoads = false;

  template <class... T>
  void operator()(T&... members) {
    (member(members), ...);
  }
  void raw(void* from, std::size_t size) { bytes_.append(static_cast<const char*>(from), size); }
  const std::string& bytes() const { return bytes_; }

 private:
  template <class T>
  void member(T& value);
  std::string bytes_;
};

/// Takes them apart again. InputError where they end too early.
class InArchive {
 public:
  static constexpr bool kLoads = true;

  /// `bytes` must outlive it.
  explicit InArchive(std::string_view bytes) : rest_(bytes) {}

  template <class... T>
  void operator()(T&... members) {
    (member(members), ...);
  }
  void raw(void* to, std::size_t size) {
    if (size > rest_.size()) throw InputError("ends too early for what it should hold");
    std::memcpy(to, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  std::size_t left() const { return rest_.size(); }

 private:
  template <class T>
  void member(T& value);
  std::string_view rest_;
};

template <class Archive, Number T>
void archive_member(Archive& archive, T& value) {
  archive.raw(&value, sizeof value);
}

template <class Archive>
void archive_member(Archive& archive, bool& value) {
  std::uint8_t byte = value ? 1 : 0;
  archive(byte);
  value = byte != 0;
}

template <class Archive, class T>
requires requires(T& value, Archive& archive) { value.archive(archive); }
void archive_member(Archive& archive, T& value) { value.archive(archive); }

template <class Archive, int N, int Width>
void archive_member(Archive& archive, Lanes<N, Width>& lanes) {
  archive.raw(lanes.begin(), N * sizeof(double));
}

template <class Archive, class T, std::size_t N>
void archive_member(Archive& archive, std::array<T, N>& values) {
  for (T& value : values) archive(value);
}

template <class Archive, class T>
void archive_member(Archive& archive, std::optional<T>& value) {
  bool there = value.has_value();
  archive(there);
  if constexpr (Archive::kLoads) {
    value.reset();
    if (there) value.emplace();
  }
  if (there) archive(*value);
}

/// Strings and vectors.
template <class Archive, class T>
requires requires(T& values) {
  values.resize(1);
  values.data();
}
void archive_member(Archive& archive, T& values) {
  std::uint64_t size = values.size();
  archive(size);
  if constexpr (Archive::kLoads) {
    if (size > archive.left()) throw InputError("ends too early for what it should hold");
    values.resize(size);
  }
  for (auto& value : values) archive(value);
}

template <class T>
void OutArchive::member(T& value) {
  archive_member(*this, value);
}

template <class T>
void InArchive::member(T& value) {
  archive_member(*this, value);
}

}  // namespace armukf
