#include "armukf/io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr mode_t kReadWriteForAll = 0666;  // before the umask
constexpr mode_t kPermissions = 07777;

bool is_standard_output(const std::string& path) { return path == "-" || path == "/dev/stdout"; }

InputError open_failure(const std::string& path, int error) {
  return InputError(shown_name(path), 0, "",
                    "cannot open for writing: " + std::generic_category().message(error));
}

std::system_error write_failure(const std::string& name) {
  return {errno, std::generic_category(), name + ": cannot write"};
}

/// For writing, with that flag besides.
Descriptor opened(const std::string& path, int flag) {
  const int number =
      is_standard_output(path)
          ? ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0)
          : ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flag, kReadWriteForAll);
  if (number < 0) throw open_failure(path, errno);
  return Descriptor(number);
}

/// What an output that takes something takes without making its writer wait, in bytes.
std::size_t room(int descriptor) {
  const int capacity = ::fcntl(descriptor, F_GETPIPE_SZ);
  int unread = 0;
  const bool empty = capacity > 0 && ::ioctl(descriptor, FIONREAD, &unread) == 0 && unread == 0;
  // Half of it, should another process write to the same pipe.
  return std::max<std::size_t>(PIPE_BUF, empty ? static_cast<std::size_t>(capacity) / 2 : 0);
}

bool is_regular(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

/// Waits until whoever reads the output can take a part of it that is no longer than PIPE_BUF;
/// false if that takes too long.
bool can_take(int descriptor, std::chrono::milliseconds patience) {
  using Clock = std::chrono::steady_clock;
  pollfd output{.fd = descriptor, .events = POLLOUT, .revents = 0};
  const auto end = Clock::now() + patience;
  for (auto left = patience; left.count() > 0;
       left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now())) {
    const int ready = ::poll(&output, 1, static_cast<int>(left.count()));
    if (ready > 0 || (ready < 0 && errno != EINTR)) return true;
  }
  return false;
}

/// The same for as long as nothing is to stop, and a second more: whichever thread a signal
/// reaches.
bool takes(int descriptor, StopFlag stop) {
  using namespace std::chrono_literals;
  while (*stop == 0)
    if (can_take(descriptor, 100ms)) return true;
  return can_take(descriptor, 1s);
}

/// Whether a file's name is that of `target` while it was being written by a process that is gone.
bool is_stale(const std::string& name, const std::string& target) {
  int process = 0;
  int attempt = 0;
  int end = 0;
  if (!name.starts_with(target)) return false;
  const char* rest = name.c_str() + target.size();
  return std::sscanf(rest, ".%d.%d.tmp%n", &process, &attempt, &end) == 2 && end > 0 &&
         rest[end] == '\0' && ::kill(process, 0) != 0 && errno == ESRCH;
}

}  // namespace

void remove_stale(const std::string& target) {
  std::error_code ignored;  // who cannot look cannot tidy
  const std::filesystem::path path = std::filesystem::weakly_canonical(target, ignored);
  for (const auto& entry : std::filesystem::directory_iterator(path.parent_path(), ignored))
    if (is_stale(entry.path().filename().string(), path.filename().string()))
      std::filesystem::remove(entry.path(), ignored);
}

std::string shown_name(const std::string& path) { return path == "-" ? "<stdout>" : path; }

Descriptor open_for_writing(const std::string& path) { return opened(path, O_TRUNC); }

Descriptor open_for_appending(const std::string& path) { return opened(path, O_APPEND); }

void make_empty(int descriptor, const std::string& name) {
  if (is_regular(descriptor) && ::ftruncate(descriptor, 0) != 0) throw write_failure(name);
}

void check_writable(const std::string& path) {
  if (is_standard_output(path)) return;
  const bool exists = ::access(path.c_str(), F_OK) == 0;
  const auto folder = std::filesystem::path(path).parent_path();
  const std::string place = exists ? path : folder.empty() ? "." : folder.string();
  if (::access(place.c_str(), W_OK) != 0) throw open_failure(path, errno);
  if (std::filesystem::is_directory(path)) throw open_failure(path, EISDIR);
}

bool write_all(int descriptor, std::string_view bytes, const std::string& name, StopFlag stop) {
  const bool waits = stop != nullptr && !is_regular(descriptor);
  while (!bytes.empty()) {
    if (waits && !takes(descriptor, stop)) {
      errno = ETIMEDOUT;
      throw write_failure(name);
    }
    const std::size_t part = waits ? std::min(bytes.size(), room(descriptor)) : bytes.size();
    const auto count = ::write(descriptor, bytes.data(), part);
    if (count >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EPIPE) {
      return false;
    } else if (errno == EAGAIN) {
      can_take(descriptor, std::chrono::seconds(1));
    } else if (errno != EINTR) {
      throw write_failure(name);
    }
  }
  return true;
}

AtomicFile::AtomicFile(const std::string& target) : name_(shown_name(target)) {
  struct stat status {};
  const bool exists = !is_standard_output(target) && ::stat(target.c_str(), &status) == 0;
  if (is_standard_output(target) || (exists && !S_ISREG(status.st_mode))) {
    output_ = open_for_writing(target);
    return;
  }
  if (exists) check_writable(target);
  open_beside(target);
  if (exists) ::fchmod(output_.number(), status.st_mode & kPermissions);
}

/// Opens a new file in the directory of the target, so that a rename reaches it.
void AtomicFile::open_beside(const std::string& target) {
  std::error_code unresolved;  // such a target fails to open below
  const auto resolved = std::filesystem::weakly_canonical(target, unresolved);
  target_ = unresolved ? target : resolved.string();
  for (int attempt = 0;; ++attempt) {
    const std::string path = fmt::format("{}.{}.{}.tmp", target_, ::getpid(), attempt);
    const int number =
        ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kReadWriteForAll);
    if (number < 0 && errno == EEXIST) continue;
    if (number < 0) throw open_failure(target, errno);
    output_ = Descriptor(number);
    temporary_ = path;
    return;
  }
}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view text) { write_all(descriptor(), text, name_); }

void AtomicFile::commit() {
  if (temporary_.empty()) return;
  // Without the sync a crash may leave the new name with no content, and a full disk may show late.
  sync(descriptor());
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) throw write_failure(name_);
  temporary_.clear();
  // The name is on disk once its folder is; a folder that may not be opened is left to itself.
  const auto folder = std::filesystem::path(target_).parent_path();
  const Descriptor opened(
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.number() >= 0) ::fsync(opened.number());
}

void AtomicFile::sync(int descriptor) const {
  while (::fsync(descriptor) != 0)
    if (errno != EINTR) throw write_failure(name_);
}

}  // namespace armukf
