#include "armukf/batch/speed_reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

using enum ExperimentKind;

constexpr int kSamples = 4000;
constexpr double kSampleTime = 5e-4;  // s: a period of 2 s, lines at multiples of 0.5 Hz
constexpr double kRounding = 1e-9;    // rad/s: sums of some thousand terms of about 20

std::vector<double> reference(ExperimentKind kind, std::uint64_t seed = 1) {
  return speed_reference(kind, {}, kSamples, kSampleTime, seed);
}

double peak(const std::vector<double>& values) {
  const auto [least, greatest] = std::ranges::minmax(values);
  return std::max(greatest, -least);
}

/// Amplitude of cos(2 pi line n / N + phase) in the values.
double amplitude(const std::vector<double>& values, int line) {
  std::complex<double> sum;
  const double step = 2.0 * std::numbers::pi * line / static_cast<double>(values.size());
  for (std::size_t n = 0; n < values.size(); ++n)
    sum += std::polar(values[n], -step * static_cast<double>(n));
  return 2.0 * std::abs(sum) / static_cast<double>(values.size());
}

TEST(SpeedReference, MultisineHasItsPeak) {
  for (const std::uint64_t seed : {1, 2, 3})
    EXPECT_NEAR(peak(reference(kValidation2, seed)), 16.0, kRounding);
}

TEST(SpeedReference, MultisineIsFlatFromOneToFortyHertzAndNothingElse) {
  const std::vector<double> multisine = reference(kValidation2);
  const double flat = amplitude(multisine, 2);
  EXPECT_GT(flat, 0.1);
  for (int line = 2; line <= 80; ++line) EXPECT_NEAR(amplitude(multisine, line), flat, kRounding);
  for (const int line : {1, 81, 82, 200, 1999}) EXPECT_LT(amplitude(multisine, line), kRounding);
}

TEST(SpeedReference, SquareWaveGoesThroughAFirstOrderLowPass) {
  const ReferenceShape alone{.multisine_peak = 0.0};
  const std::vector<double> wave = speed_reference(kEstimation, alone, kSamples, kSampleTime, 1);
  const double decay = std::exp(-2.0 * std::numbers::pi * kSampleTime);  // at 1 Hz
  for (int n = 0; n < kSamples; ++n) {
    const double level = n < kSamples / 2 ? 20.0 : -20.0;
    EXPECT_NEAR(wave[(n + 1) % kSamples] - level, decay * (wave[n] - level), kRounding) << n;
  }
}

TEST(SpeedReference, EstimationIsAMultisineOfTheSamePeakOnTheSquareWave) {
  const ReferenceShape alone{.multisine_peak = 0.0};
  const std::vector<double> wave = speed_reference(kEstimation, alone, kSamples, kSampleTime, 1);
  std::vector<double> multisine = reference(kEstimation);
  for (int n = 0; n < kSamples; ++n) multisine[n] -= wave[n];
  EXPECT_NEAR(peak(multisine), 16.0, kRounding);
}

TEST(SpeedReference, SlowSinesHaveTheirPeakAndThreeLines) {
  const std::vector<double> sines = reference(kValidation3);
  ASSERT_EQ(sines.size(), 20000U);  // 10 s
  EXPECT_NEAR(peak(sines), 40.0, kRounding);
  for (const int line : {1, 3, 5})
    EXPECT_NEAR(amplitude(sines, line), amplitude(sines, 1), kRounding);
  for (const int line : {2, 4, 6, 7}) EXPECT_LT(amplitude(sines, line), kRounding);
}

TEST(SpeedReference, PhasesFollowTheSeedAndTheKind) {
  for (const ExperimentKind kind : {kEstimation, kValidation1, kValidation2, kValidation3}) {
    EXPECT_EQ(reference(kind, 7), reference(kind, 7));
    EXPECT_NE(reference(kind, 7), reference(kind, 8));
  }
  EXPECT_NE(reference(kEstimation, 7), reference(kValidation1, 7));
}

TEST(SpeedReference, RecordThatHoldsNoLineIsAnInputError) {
  EXPECT_THROW(speed_reference(kEstimation, {}, 40, kSampleTime, 1), InputError);  // 20 ms
  EXPECT_THROW(speed_reference(kValidation2, {}, 400, 0.0125, 1), InputError);     // 80 Hz
}

TEST(SpeedReference, NamesFindTheirKinds) {
  for (const std::string_view name : experiment_names())
    EXPECT_EQ(name_of(find_experiment(name)), name);
  EXPECT_THROW(find_experiment("validation"), InputError);
}

}  // namespace
}  // namespace armukf
