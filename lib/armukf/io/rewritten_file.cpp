#include "armukf/io/rewritten_file.hpp"

#include <pthread.h>

#include <csignal>
#include <utility>

#include "armukf/io/atomic_file.hpp"

namespace armukf {
namespace {

/// While it lives, threads are started that no signal reaches: those are the main thread's.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

RewrittenFile::RewrittenFile(std::string path) : path_(std::move(path)) {
  remove_stale(path_);
  const SignalsBlocked blocked;
  writer_ = std::jthread([this] { work(); });
}

RewrittenFile::~RewrittenFile() {
  const std::lock_guard lock(mutex_);
  closing_ = true;
  changed_.notify_all();
}

bool RewrittenFile::busy() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

void RewrittenFile::put(std::string content) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !waiting_; });
  content_ = std::move(content);
  waiting_ = true;
  changed_.notify_all();
}

void RewrittenFile::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !waiting_; });
}

std::string RewrittenFile::take_failure() {
  const std::lock_guard lock(mutex_);
  return std::exchange(failure_, {});
}

/// Writes what is put until the end, and what still waits then. content_ is its own while waiting_.
void RewrittenFile::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return waiting_ || closing_; });
    if (!waiting_) return;
    lock.unlock();
    std::string failure;
    try {
      AtomicFile file(path_);
      file.write(content_);
      file.commit();
    } catch (const std::exception& error) {
      failure = error.what();
    }
    lock.lock();
    failure_ = std::move(failure);
    waiting_ = false;
    changed_.notify_all();
  }
}

}  // namespace armukf
