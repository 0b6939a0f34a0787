#include "outputs.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "armukf/core/error.hpp"
#include "armukf/io/atomic_file.hpp"

namespace armukf::apps {
namespace {

/// Which file a path leads to, whatever the path: one that exists by its place on the disk.
class File {
 public:
  static File read_from(const std::string& path) {
    File file(path);
    if (path == "-") file.exists_ = ::fstat(STDIN_FILENO, &file.status_) == 0;
    return file;
  }
  explicit File(const std::string& path) {
    exists_ = path != "-" && ::stat(path.c_str(), &status_) == 0;
    std::error_code unresolved;
    path_ = std::filesystem::weakly_canonical(path, unresolved);
  }

  /// Whether writing replaces what it holds.
  bool is_replaced() const { return !exists_ || S_ISREG(status_.st_mode); }

  bool operator==(const File& other) const {
    if (exists_ != other.exists_) return false;
    if (exists_)
      return status_.st_dev == other.status_.st_dev && status_.st_ino == other.status_.st_ino;
    return path_ == other.path_;
  }

 private:
  bool exists_ = false;
  struct stat status_ {};
  std::filesystem::path path_;
};

}  // namespace

void check_outputs(const std::vector<std::string>& records, const std::vector<Output>& outputs) {
  std::vector<std::pair<const char*, File>> earlier;
  const char* on_standard_output = nullptr;
  for (const auto& [option, path] : outputs) {
    if (path == "-" && on_standard_output != nullptr)
      throw InputError(
          fmt::format("{}: standard output is taken by {}", option, on_standard_output));
    if (path == "-") on_standard_output = option;
    if (path.empty() || path == "-") continue;
    const File file(path);
    if (!file.is_replaced()) continue;
    for (const std::string& record : records)
      if (file == File::read_from(record))
        throw InputError(path, 0, option, "would replace the record that is read");
    for (const auto& [other_option, other] : earlier)
      if (file == other)
        throw InputError(path, 0, option, fmt::format("is written by {}, too", other_option));
    check_writable(path);
    earlier.emplace_back(option, file);
  }
}

}  // namespace armukf::apps
