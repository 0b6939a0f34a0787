#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace armukf {

/// A file that is written anew again and again, by a thread of its own, so that nobody waits for a
/// disk. At any instant the file is one of those that were offered, whole; a write that fails
/// leaves the last one.
class RewrittenFile {
 public:
  /// Removes what a killed writer of the same file has left beside it.
  explicit RewrittenFile(std::string path);
  ~RewrittenFile();
  RewrittenFile(const RewrittenFile&) = delete;
  RewrittenFile& operator=(const RewrittenFile&) = delete;

  /// Whether the last content is still being written, so that a new one would have to wait.
  bool busy() const;

  /// Takes a content; waits where the last one is still being written.
  void put(std::string content);

  /// Waits until the last content is on disk.
  void finish();

  /// Why the last content could not be written, once; empty otherwise.
  std::string take_failure();

 private:
  void work();

  std::string path_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::string content_;
  bool waiting_ = false;  // content_, to be written
  bool closing_ = false;
  std::string failure_;
  std::jthread writer_;  // last: it uses all of the above
};

}  // namespace armukf
