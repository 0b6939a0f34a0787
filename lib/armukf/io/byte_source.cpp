#include "armukf/io/byte_source.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr std::size_t kMaxLine = std::size_t{1} << 20;   // bytes; a longer line is no record
constexpr std::size_t kReadSize = std::size_t{1} << 16;  // bytes; what a pipe holds, fits in L2

// A signal between the test of the stop flag and the wait would go unseen: wait no longer than
// this.
constexpr int kStopCheckMs = 100;

// A followed file's end is looked at so often, ever more seldom while nothing comes.
constexpr int kLeastIdleMs = 1;
constexpr int kMostIdleMs = 64;

constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

InputError failure(const std::string& name, const std::string& action, int error) {
  return InputError(name, 0, "", action + ": " + std::generic_category().message(error));
}

bool is_set(StopFlag stop) { return stop != nullptr && *stop != 0; }

Descriptor opened(const std::string& path, StopFlag stop) {
  for (;;) {
    const int number = path == "-" ? ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                   : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (number >= 0) return Descriptor(number);
    if (errno != EINTR) throw failure(path == "-" ? "<stdin>" : path, "cannot open", errno);
    if (is_set(stop)) return Descriptor();  // a named pipe that nobody came to write
  }
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

ByteSource::ByteSource(const std::string& path, StopFlag stop, FileEnd file_end)
    : ByteSource(opened(path, stop), path == "-" ? "<stdin>" : path, stop) {
  if (file_end == FileEnd::kEnds || live_) return;
  path_ = path;
  live_ = true;
  size_.reset();
}

ByteSource::ByteSource(Descriptor input, std::string name, StopFlag stop)
    : input_(std::move(input)),
      name_(std::move(name)),
      stop_(stop),
      buffer_(std::make_unique_for_overwrite<char[]>(kMaxLine + 2 * kReadSize)) {
  if (input_.number() < 0) {
    ended_ = stopped_ = true;
    return;
  }
  struct stat status {};
  if (::fstat(input_.number(), &status) != 0) throw failure(name_, "cannot open", errno);
  if (S_ISDIR(status.st_mode)) throw failure(name_, "cannot open", EISDIR);
  live_ = !S_ISREG(status.st_mode);
  if (live_) return;
  const auto left = status.st_size - ::lseek(input_.number(), 0, SEEK_CUR);
  size_ = left > 0 ? static_cast<std::uint64_t>(left) : 0;
}

std::optional<std::string_view> ByteSource::next_line() {
  if (dropping_ && !drop_rest()) return std::nullopt;
  for (;;) {
    const bool complete = has_line();
    if (scanned_ - begin_ > kMaxLine) {
      dropping_ = true;
      begin_ = scanned_;
      throw LineError(name_, ++line_number_, "", "line is longer than 1 MiB");
    }
    if (complete) break;
    if (!read()) return last_line();
  }
  return take_line();
}

/// Whether there is a next line.
bool ByteSource::drop_rest() {
  while (dropping_) {
    if (has_line()) {
      begin_ = ++scanned_;
      dropping_ = false;
    } else {
      begin_ = scanned_;
      if (!read()) return false;
    }
  }
  return true;
}

bool ByteSource::has_line() {
  const void* newline = std::memchr(buffer_.get() + scanned_, '\n', end_ - scanned_);
  scanned_ = newline == nullptr
                 ? end_
                 : static_cast<std::size_t>(static_cast<const char*>(newline) - buffer_.get());
  return newline != nullptr;
}

std::string_view ByteSource::front_line() const {
  return {buffer_.get() + begin_, scanned_ - begin_};
}

std::optional<std::string_view> ByteSource::last_line() {
  if (begin_ == end_ || stopped_) return std::nullopt;
  terminated_ = false;
  return take_line();
}

std::string_view ByteSource::take_line() {
  std::string_view line = front_line();
  begins_file_ = begin_ == file_begin_;
  if (begins_file_) {
    line_number_ = 0;
    file_begin_ = kNowhere;
  }
  scanned_ += terminated_ ? 1 : 0;
  begin_ = scanned_;
  if (++line_number_ == 1 && line.starts_with(kByteOrderMark)) {
    line.remove_prefix(kByteOrderMark.size());
  }
  return line;
}

/// Appends to the buffer what the input offers; false at its end.
bool ByteSource::read() {
  make_room();
  while (!ended_) {
    if (is_set(stop_)) {
      ended_ = stopped_ = true;
    } else if (!live_ || !path_.empty() || wait()) {
      const auto count = ::read(input_.number(), buffer_.get() + end_, kReadSize);
      if (count > 0) {
        end_ += static_cast<std::size_t>(count);
        received_ += static_cast<std::size_t>(count);
        idle_ms_ = kLeastIdleMs;
        return true;
      }
      if (count == 0 && !path_.empty()) {
        if (await_growth()) return true;
        continue;
      }
      ended_ = count == 0;
      if (count < 0 && errno != EINTR && errno != EAGAIN) {
        throw failure(name_, "cannot read", errno);
      }
    }
  }
  return false;
}

/// At the end of a followed file: waits a little, or goes on to the next of its name. Whether there
/// is a line to be taken that was not there before.
bool ByteSource::await_growth() {
  struct stat open {};
  struct stat named {};
  ::fstat(input_.number(), &open);
  if (replaced_) {
    Descriptor next(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
    replaced_ = next.number() < 0;  // gone again, and to be looked for again
    if (!replaced_) {
      begin_next_file(std::move(next));
      return true;
    }
  }
  if (open.st_size < ::lseek(input_.number(), 0, SEEK_CUR)) {  // cut, and written anew
    begin_next_file(Descriptor(::fcntl(input_.number(), F_DUPFD_CLOEXEC, 0)));
    ::lseek(input_.number(), 0, SEEK_SET);
    return true;
  }
  if (::stat(path_.c_str(), &named) == 0) {
    replaced_ = named.st_ino != open.st_ino || named.st_dev != open.st_dev;
    if (replaced_) return false;
  }
  ::poll(nullptr, 0, idle_ms_);
  idle_ms_ = std::min(2 * std::max(idle_ms_, kLeastIdleMs), kMostIdleMs);
  return false;
}

/// What the last file left without a newline is a line.
void ByteSource::begin_next_file(Descriptor next) {
  input_ = std::move(next);
  if (end_ > begin_ && buffer_[end_ - 1] != '\n') buffer_[end_++] = '\n';
  dropping_ = false;
  file_begin_ = end_;
}

/// Whether the input has something to say, be it that it has ended or failed.
bool ByteSource::wait() const {
  pollfd input{.fd = input_.number(), .events = POLLIN, .revents = 0};
  const int ready = ::poll(&input, 1, stop_ == nullptr ? -1 : kStopCheckMs);
  return ready > 0 || (ready < 0 && errno != EINTR);
}

void ByteSource::make_room() {
  if (begin_ == 0) return;
  std::memmove(buffer_.get(), buffer_.get() + begin_, end_ - begin_);
  end_ -= begin_;
  scanned_ -= begin_;
  if (file_begin_ != kNowhere) file_begin_ -= begin_;
  begin_ = 0;
}

}  // namespace armukf
