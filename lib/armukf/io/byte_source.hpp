#pragma once

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "armukf/core/error.hpp"

namespace armukf {

/// A line that cannot be used; those after it can be read.
class LineError : public InputError {
 public:
  using InputError::InputError;
};

/// A file descriptor that closes with its owner; -1 is none.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor();

  int number() const { return number_; }

 private:
  int number_ = -1;
};

/// A flag that a signal handler sets to end the input; null where nothing ends it.
using StopFlag = const volatile std::sig_atomic_t*;

/// Where a regular file ends.
enum class FileEnd {
  kEnds,     // where it ends now
  kFollowed  // never: another program still writes it, and may begin a new one of the same name
};

/// The lines of a file or of standard input, read through one buffer of fixed size.
class ByteSource {
 public:
  /// Opens the file, or standard input for "-"; InputError where it cannot be read.
  explicit ByteSource(const std::string& path, StopFlag stop = nullptr,
                      FileEnd file_end = FileEnd::kEnds);

  /// Reads what is open already; `name` stands for it in messages.
  ByteSource(Descriptor input, std::string name, StopFlag stop = nullptr);

  /// The next line without its newline, valid until the next call; waits for it where the input is
  /// live. Nothing at the end of input. LineError for a line longer than 1 MiB.
  std::optional<std::string_view> next_line();

  /// Whether a complete line is in the buffer, so that next_line() returns without reading.
  bool has_line();

  /// The line that next_line() would return; has_line() must hold.
  std::string_view front_line() const;

  /// Whether the last line ended by a newline, not by the end of input.
  bool terminated() const { return terminated_; }

  /// Whether the last line is the first of a file: of one that is followed there may be several.
  bool begins_file() const { return begins_file_; }

  /// Whether the stop flag ended the input; what was read of an incomplete line is dropped then.
  bool stopped() const { return stopped_; }

  /// Whether bytes may still be on their way: a pipe, a terminal, anything but a regular file that
  /// is not followed.
  bool live() const { return live_; }

  const std::string& name() const { return name_; }         // as in messages: FILE or <stdin>
  std::size_t line_number() const { return line_number_; }  // of the last line returned, from 1
  std::uint64_t consumed() const { return received_ - (end_ - begin_); }  // bytes in returned lines
  std::optional<std::uint64_t> size() const { return size_; }  // bytes in all; none if live

 private:
  bool read();
  bool drop_rest();
  bool wait() const;
  bool await_growth();
  void begin_next_file(Descriptor next);
  void make_room();
  std::optional<std::string_view> last_line();
  std::string_view take_line();

  Descriptor input_;
  std::string name_;
  StopFlag stop_;
  std::string path_;  // of what is followed; empty otherwise
  std::unique_ptr<char[]> buffer_;
  std::size_t begin_ = 0;    // buffer_[begin_, end_) is not returned yet,
  std::size_t scanned_ = 0;  // and holds no newline before scanned_
  std::size_t end_ = 0;
  std::size_t line_number_ = 0;
  std::uint64_t received_ = 0;
  std::optional<std::uint64_t> size_;
  bool live_ = false;
  bool ended_ = false;
  bool stopped_ = false;
  bool terminated_ = true;
  std::size_t file_begin_ = 0;  // where in the buffer the file at hand begins, unless passed
  bool begins_file_ = false;
  bool replaced_ = false;  // another file has the name; what the old one still holds comes first
  int idle_ms_ = 0;        // to sleep before the next look at the file's end
  bool dropping_ = false;  // what is left of a line that was too long
};

}  // namespace armukf
