#pragma once

#include <functional>

namespace armukf {

/// How many threads work at once, given what was asked for: 0 is one per processor.
int threads_for(int asked);

/// How many each of so many jobs may have for itself, where fewer jobs than threads are to be done.
int threads_of_each(int threads, int jobs);

/// Calls job(0) ... job(count - 1), each once, on that many threads (0: one per processor), in any
/// order; returns when all are done. Jobs write where no other job does, so that results do not
/// depend on the number of threads. If jobs throw, the exception of the first of them, by index, is
/// thrown here.
void for_each_job(int threads, int count, const std::function<void(int)>& job);

}  // namespace armukf
