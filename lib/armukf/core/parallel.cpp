#include "armukf/core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace armukf {
namespace {

// Of all crews: who has nothing to do may help another one, and is given back.
std::atomic<int> idle = 0;
thread_local bool in_crew = false;

/// How many threads work at once, given what was asked for.
int threads_for(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// How many idle threads there were for this one, at most so many; they are no longer idle.
int take_idle(int most) {
  if (!in_crew) return 0;
  int now = idle.load();
  for (;;) {
    const int taken = std::clamp(now, 0, std::max(0, most));
    if (idle.compare_exchange_weak(now, now - taken)) return taken;
  }
}

}  // namespace

Crew::Crew(int threads) : first_(!in_crew), helpers_(first_ ? threads_for(threads) - 1 : 0) {
  in_crew = true;
  idle += helpers_;
}

Crew::~Crew() {
  idle -= helpers_;
  if (first_) in_crew = false;
}

int idle_threads() { return in_crew ? std::max(0, idle.load()) : 0; }

void for_each_job(int count, const std::function<void(int)>& job) {
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
  const auto help = [&] {
    in_crew = true;
    work();
    ++idle;
  };
  const int taken = take_idle(count - 1);
  {
    std::vector<std::jthread> helpers;
    try {
      while (static_cast<int>(helpers.size()) < taken) helpers.emplace_back(help);
    } catch (const std::system_error&) {  // no more threads to be had: these will do
      idle += taken - static_cast<int>(helpers.size());
    }
    work();
    if (taken > 0) ++idle;  // until the others have ended
  }
  if (taken > 0) --idle;
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

void for_each_job(int threads, int count, const std::function<void(int)>& job) {
  const Crew crew(threads);
  for_each_job(count, job);
}

}  // namespace armukf
