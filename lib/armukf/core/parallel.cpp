#include "armukf/core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace armukf {

int threads_for(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int threads_of_each(int threads, int jobs) {
  return std::max(1, threads_for(threads) / std::max(1, jobs));
}

void for_each_job(int threads, int count, const std::function<void(int)>& job) {
  std::vector<std::exception_ptr> failures(std::max(0, count));
  std::atomic<int> next = 0;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        job(i);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = std::min(threads_for(threads), count); i > 1; --i) helpers.emplace_back(work);
    work();
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace armukf
