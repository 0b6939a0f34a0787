#include "armukf/filter/noise_spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

namespace armukf {
namespace {

class Noise {
 public:
  explicit Noise(ColouredNoise noise) : noise_(noise) {}
  double next(std::mt19937_64& random) {
    value_ = noise_.pole * value_ + std::sqrt(noise_.driving_variance()) * normal_(random);
    return value_;
  }

 private:
  ColouredNoise noise_;
  std::normal_distribution<double> normal_;
  double value_ = 0.0;
};

/// What is learnt from so many values of m_k = kick_{k-1} + sensor_k - sensor_{k-1}.
NoisePair learnt(const NoisePair& truth, int samples, unsigned seed, double sample_s = 0.0) {
  std::mt19937_64 random(seed);
  Noise kick(truth.kick);
  Noise sensor(truth.sensor);
  NoiseSpectrum spectrum(sample_s);
  double last = sensor.next(random);
  for (int k = 0; k < samples; ++k) {
    const double now = sensor.next(random);
    spectrum.add(kick.next(random) + now - last);
    last = now;
  }
  return spectrum.noise();
}

// Ten seconds at 2 kHz, of which half count: the deviation of a sensor's sd is below 1 %, that of
// its pole sqrt((1 - p^2) / 10000), 0.01 where it is 0.
constexpr int kSamples = 20000;

TEST(NoiseSpectrum, TellsTheSizeAndThePoleOfASensorsNoise) {
  unsigned seed = 1;
  for (const double sd : {0.1, 0.5})
    for (const double pole : {0.0, 0.5, 0.9}) {
      const NoisePair found = learnt({{0.003, 0.9}, {sd, pole}}, kSamples, seed++);
      EXPECT_NEAR(found.sensor.sd, sd, 0.15 * sd) << pole;
      EXPECT_NEAR(found.sensor.pole, pole, 0.04) << sd;
    }
}

TEST(NoiseSpectrum, TellsTheSizeAndThePoleOfATorquesNoiseThatStandsOut) {
  const NoisePair truth{{0.02, 0.9}, {0.1, 0.0}};
  const NoisePair found = learnt(truth, kSamples, 7);
  EXPECT_NEAR(found.kick.sd, truth.kick.sd, 0.2 * truth.kick.sd);
  EXPECT_NEAR(found.kick.pole, truth.kick.pole, 0.06);
  EXPECT_NEAR(found.kick.long_run_variance() / truth.kick.long_run_variance(), 1.0, 0.5);
}

TEST(NoiseSpectrum, TellsBothFromShorterBlocks) {
  const NoisePair truth{{0.05, 0.7}, {0.1, 0.4}};
  const NoisePair found = learnt(truth, kSamples, 8, 2e-3);
  EXPECT_NEAR(found.kick.sd, truth.kick.sd, 0.2 * truth.kick.sd);
  EXPECT_NEAR(found.kick.pole, truth.kick.pole, 0.1);
  EXPECT_NEAR(found.sensor.sd, truth.sensor.sd, 0.1 * truth.sensor.sd);
  EXPECT_NEAR(found.sensor.pole, truth.sensor.pole, 0.1);
}

TEST(NoiseSpectrum, FollowsANoiseThatChanges) {
  std::mt19937_64 random(3);
  NoiseSpectrum spectrum;
  std::normal_distribution<double> normal;
  double last = 0.0;
  for (int k = 0; k < 4 * kSamples; ++k) {
    const double now = (k < kSamples ? 1.0 : 0.1) * normal(random);
    spectrum.add(now - last);
    last = now;
  }
  // The first quarter still has the part (1/4)^3 of the mean: 1/64 of a variance a hundred times
  // as large.
  EXPECT_LT(spectrum.noise().sensor.sd, 0.2);
}

/// The same where one in `every` m's is missing, and known only by the sum with the next.
NoiseSpectrum learnt_with_missing(double sensor_sd, int every) {
  std::mt19937_64 random(5);
  Noise sensor({sensor_sd, 0.0});
  NoiseSpectrum spectrum;
  double last = sensor.next(random);
  for (int k = 0; k < kSamples; ++k) {
    double now = sensor.next(random);
    const bool missing = k % every == 0;
    if (missing) now = sensor.next(random);
    spectrum.add(now - last, missing ? 2 : 1);
    last = now;
  }
  return spectrum;
}

TEST(NoiseSpectrum, IsLearntWhereFewAreMissing) {
  for (const int every : {1000, 50})
    EXPECT_NEAR(learnt_with_missing(0.1, every).noise().sensor.sd, 0.1, 0.006) << every;
  EXPECT_FALSE(learnt_with_missing(0.1, 3).has_learnt());
}

TEST(NoiseSpectrum, IsNeverNone) {
  NoiseSpectrum spectrum;
  for (int k = 0; k < kSamples; ++k) spectrum.add(0.0);
  EXPECT_GE(spectrum.noise().sensor.sd, 1e-5);
  EXPECT_GT(spectrum.noise().kick.sd, 0.0);
}

/// A block is a second at most, so that slow records do not wait much longer for their noise.
TEST(NoiseSpectrum, HasLearntNothingBeforeTwoBlocks) {
  for (const auto& [sample_s, block] :
       {std::pair{0.0, 1024}, {5e-4, 1024}, {1e-3, 1024}, {2e-3, 512}, {1e-5, 1024}, {1.0, 128}}) {
    NoiseSpectrum spectrum(sample_s);
    const int second = block + block / 2;
    for (int k = 0; k + 1 < second; ++k) EXPECT_FALSE(spectrum.add(0.1 * (k % 3))) << sample_s;
    EXPECT_FALSE(spectrum.has_learnt()) << sample_s;
    EXPECT_TRUE(spectrum.add(0.1)) << sample_s;
  }
}

}  // namespace
}  // namespace armukf
