#pragma once

#include <functional>

namespace armukf {

/// The threads that work together while this lives: the one that makes it, and helpers that come
/// and go with the jobs. Within a crew, or one of its jobs, another one is that one.
class Crew {
 public:
  explicit Crew(int threads);  // 0: one per processor
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

 private:
  bool first_;  // whether there was none
  int helpers_;
};

/// How many of this thread's crew have nothing to do at the moment.
int idle_threads();

/// Calls job(0) ... job(count - 1), each once, in any order; returns when all are done. This thread
/// works, and whoever of its crew is idle when this is called; without a crew it works alone. A job
/// may do the same: it is helped by those who found no job left. Jobs write where no other job
/// does, so that results do not depend on the number of threads. If jobs throw, the exception of
/// the first of them, by index, is thrown here.
void for_each_job(int count, const std::function<void(int)>& job);

/// The same with a crew of that many, where there is none.
void for_each_job(int threads, int count, const std::function<void(int)>& job);

}  // namespace armukf
