#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <string>

#include "armukf/batch/experiment.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/watch.hpp"

/// What a step allocates, counted by replacing operator new: a program of its own.
namespace {

std::atomic<std::size_t> allocations = 0;

}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto unit = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(unit, (size + unit - 1) / unit * unit)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace armukf {
namespace {

/// The plant may have what the model lacks: then the watch makes innovations white by itself.
class NothingAllocated : public testing::TestWithParam<std::string> {};

TEST_P(NothingAllocated, ByStepsThatAreWatchedUnlessSomethingChanges) {
  Model plant = published_estimate();
  if (!GetParam().empty()) {
    plant.add_effect(GetParam());
    plant.parameter(GetParam()).value = 1.0;  // N.m: no noise that the filter would learn
  }
  ExperimentSettings experiment;
  experiment.sensor_noise = 0.1;
  experiment.torque_disturbance = 0.1;
  const Record record = simulate_experiment(plant, experiment).record;
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  constexpr double kSettled = 4.5;  // s: the watch has begun, and looked
  std::size_t before = 0;
  for (const Sample& sample : record.samples) {
    if (sample.t < kSettled) before = allocations;
    ASSERT_TRUE(watch.see(session, sample, session.step(sample)).empty()) << sample.t;
  }
  EXPECT_EQ(allocations - before, 0U);
}

INSTANTIATE_TEST_SUITE_P(All, NothingAllocated, testing::Values("", "torque_ripple"));

}  // namespace
}  // namespace armukf
