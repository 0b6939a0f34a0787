#include "armukf/io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr mode_t kReadWriteForAll = 0666;  // before the umask
constexpr mode_t kPermissions = 07777;

bool is_standard_output(const std::string& path) { return path == "-" || path == "/dev/stdout"; }

std::string shown_name(const std::string& path) { return path == "-" ? "<stdout>" : path; }

InputError open_failure(const std::string& path, int error) {
  return InputError(shown_name(path), 0, "",
                    "cannot open for writing: " + std::generic_category().message(error));
}

std::system_error write_failure(const std::string& name) {
  return {errno, std::generic_category(), name + ": cannot write"};
}

}  // namespace

Descriptor open_for_writing(const std::string& path) {
  const int number =
      is_standard_output(path)
          ? ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0)
          : ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kReadWriteForAll);
  if (number < 0) throw open_failure(path, errno);
  return Descriptor(number);
}

bool write_all(int descriptor, std::string_view bytes, const std::string& name) {
  while (!bytes.empty()) {
    const auto count = ::write(descriptor, bytes.data(), bytes.size());
    if (count >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EPIPE) {
      return false;
    } else if (errno == EAGAIN) {
      pollfd output{.fd = descriptor, .events = POLLOUT, .revents = 0};
      ::poll(&output, 1, -1);
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
  if (exists && ::access(target.c_str(), W_OK) != 0) throw open_failure(target, errno);
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
  if (::fsync(descriptor()) != 0) throw write_failure(name_);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) throw write_failure(name_);
  temporary_.clear();
}

}  // namespace armukf
