#include "armukf/core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
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

TEST(Parallel, FewJobsShareTheThreads) {
  EXPECT_EQ(threads_of_each(8, 3), 2);
  EXPECT_EQ(threads_of_each(2, 5), 1);
  EXPECT_EQ(threads_of_each(4, 0), 4);
  EXPECT_EQ(threads_of_each(1, 1), 1);
  EXPECT_GE(threads_of_each(0, 1), 1);
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
