#include "armukf/core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace armukf {
namespace {

TEST(Parallel, EveryJobIsDoneOnce) {
  for (const int threads : {0, 1, 2, 7}) {
    std::vector<std::atomic<int>> done(100);
    for_each_job(threads, 100, [&](int i) { ++done[i]; });
    for (const std::atomic<int>& count : done) EXPECT_EQ(count, 1) << threads;
  }
  for_each_job(2, 0, [](int) { FAIL(); });
}

/// Of jobs that each wait until so many are at work at once, or a while.
int most_at_once(int jobs, const std::function<void(const std::function<void(int)>&)>& run) {
  std::atomic<int> at_work = 0;
  std::atomic<int> most = 0;
  run([&](int) {
    const int now = ++at_work;
    int seen = most;
    while (seen < now && !most.compare_exchange_weak(seen, now)) {
    }
    for (int ms = 0; most < jobs && ms < 50; ++ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    --at_work;
  });
  return most;
}

TEST(Parallel, WithoutACrewAThreadWorksAlone) {
  EXPECT_EQ(idle_threads(), 0);
  EXPECT_EQ(most_at_once(2, [](const auto& job) { for_each_job(4, job); }), 1);
}

TEST(Parallel, ACrewIsAsManyAsWereAskedFor) {
  const Crew crew(3);
  EXPECT_EQ(idle_threads(), 2);
  EXPECT_EQ(most_at_once(3, [](const auto& job) { for_each_job(6, job); }), 3);
  EXPECT_EQ(idle_threads(), 2);
  const Crew within(8);
  EXPECT_EQ(idle_threads(), 2);
}

TEST(Parallel, WhoFindsNoJobLeftHelpsWithThoseOfAnother) {
  const Crew crew(2);
  std::atomic<bool> other_done = false;
  EXPECT_EQ(most_at_once(2,
                         [&](const auto& job) {
                           for_each_job(2, [&](int i) {
                             if (i == 1) {
                               other_done = true;
                               return;
                             }
                             while (!other_done || idle_threads() == 0) std::this_thread::yield();
                             for_each_job(2, job);
                           });
                         }),
            2);
  EXPECT_EQ(idle_threads(), 1);
}

TEST(Parallel, AFailureLeavesTheCrewWhole) {
  const Crew crew(2);
  EXPECT_THROW(for_each_job(4, [](int) { throw std::runtime_error("all"); }), std::runtime_error);
  EXPECT_EQ(idle_threads(), 1);
}

TEST(Parallel, TheFirstFailureByIndexIsThrownAndTheOtherJobsAreDone) {
  std::atomic<int> done = 0;
  try {
    for_each_job(3, 50, [&](int i) {
      if (i % 10 == 4) throw std::runtime_error(std::to_string(i));
      ++done;
    });
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "4");
  }
  EXPECT_EQ(done, 45);
}

}  // namespace
}  // namespace armukf
