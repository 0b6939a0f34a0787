#include "armukf/diagnosis/spectrum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

namespace armukf {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::vector<double> noise(std::size_t count) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> e(count);
  for (double& v : e) v = normal(random);
  return e;
}

constexpr double kOff = 0.02;  // of the resolution, by which a parabola through three lines errs

/// Deviation of a sine's frequency as its samples tell it, of the resolution. Source: D. C. Rife,
/// R. R. Boorstyn, IEEE Trans. Information Theory 20 (1974).
double deviation(double amplitude, double noise, double count) {
  return std::sqrt(6.0) / std::numbers::pi * noise / amplitude * std::sqrt(2.0 / count) /
         std::numbers::sqrt2;
}

/// Ten minutes at 2 kHz, which sums over lines would never end.
TEST(Lines, StandOutAtTheirFrequencyWithTheirAmplitude) {
  struct Truth {
    double hertz;
    double amplitude;
  };
  for (const std::size_t count : {8000, 1200000}) {
    const std::vector<Truth> truth{{7.013, 0.6}, {63.2417, 0.4}, {0.9, 0.3}};
    const double noise_of_one = std::sqrt(2.0 / static_cast<double>(count));
    std::vector<double> t;
    std::vector<double> e = noise(count);
    for (std::size_t k = 0; k < count; ++k) {
      t.push_back(100.0 + 5e-4 * static_cast<double>(k));
      for (const auto& [hertz, amplitude] : truth)
        e[k] += amplitude * std::cos(kTurn * hertz * t[k] + 0.4);
    }
    const std::vector<SpectralLine> lines = lines_over_time(t, e, 100.0, 30.0, 3).strongest;
    ASSERT_EQ(lines.size(), 3U);
    for (const Truth& sine : truth) {
      const auto line = std::ranges::min_element(
          lines, {}, [&](const SpectralLine& l) { return std::abs(l.frequency - sine.hertz); });
      const double off = kOff + 4.0 * deviation(sine.amplitude, 1.0, static_cast<double>(count));
      EXPECT_NEAR(line->frequency, sine.hertz, off / (t.back() - t.front())) << count;
      EXPECT_NEAR(line->amplitude, sine.amplitude, 4.0 * noise_of_one) << count;
    }
  }
}

/// Of a record that is not sampled evenly, has a gap and lacks values.
TEST(Lines, AreThoseOfThePlainSums) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> jitter(0.2, 1.8);
  std::vector<double> t;
  std::vector<double> e = noise(4000);
  double at = 3.0;
  for (std::size_t k = 0; k < e.size(); ++k) {
    t.push_back(at += 5e-4 * jitter(random) + (k == 1700 ? 0.3 : 0.0));
    e[k] += 1.5 * std::sin(kTurn * 43.0 * at) + 0.5 * std::cos(kTurn * 91.0 * at);
    if (k % 7 == 3) e[k] = std::nan("");
  }
  const auto amplitude = [&](double hertz) {
    std::complex<double> sum = 0.0;
    double count = 0.0;
    for (std::size_t k = 0; k < e.size(); ++k) {
      if (std::isnan(e[k])) continue;
      sum += std::polar(1.0, -kTurn * hertz * t[k]) * e[k];
      ++count;
    }
    return 2.0 * std::abs(sum) / count;
  };
  const std::vector<SpectralLine> lines = lines_over_time(t, e, 100.0, 20.0, 5).strongest;
  ASSERT_GE(lines.size(), 2U);
  for (const SpectralLine& line : lines) {
    EXPECT_NEAR(line.amplitude, amplitude(line.frequency), 1e-9) << line.frequency;
    for (const double aside : {-0.1, 0.1})  // of the resolution
      EXPECT_LT(amplitude(line.frequency + aside / (t.back() - t.front())), line.amplitude)
          << line.frequency;
  }
}

/// How a motor turns: steadily, either way, to and fro, and with a rest of half the record.
struct Motion {
  const char* name;
  double (*angle)(double t);
};

constexpr std::array kMotions{
    Motion{"forward", [](double t) { return 20.0 * t; }},
    Motion{"backward", [](double t) { return -20.0 * t; }},
    Motion{"unevenly", [](double t) { return 20.0 * t + 5.0 * std::sin(2.0 * t); }},
    Motion{"to and fro", [](double t) { return 16.0 * std::sin(4.0 * t); }},
    Motion{"with a rest", [](double t) { return 40.0 * (std::min(t, 1.0) + std::max(t, 3.0)); }},
};

TEST(Lines, OverTheAngleDoNotDependOnHowTheMotorTurns) {
  for (const Motion& motion : kMotions) {
    std::vector<double> angle;
    std::vector<double> e = noise(8000);
    for (std::size_t k = 0; k < e.size(); ++k) {
      angle.push_back(motion.angle(5e-4 * static_cast<double>(k)));
      e[k] = 0.2 * e[k] + 0.3 * std::cos(6.1 * angle[k] + 1.0);
    }
    const auto [low, high] = std::ranges::minmax(angle);
    const std::vector<SpectralLine> lines = lines_over_angle(angle, e, 50.0, 20.0, 3).strongest;
    ASSERT_FALSE(lines.empty()) << motion.name;
    // Where half the record stands, 4000 values are left.
    const double off = kOff + 4.0 * deviation(0.3, 0.2, 4000.0);
    EXPECT_NEAR(lines[0].frequency, 6.1, off * kTurn / (high - low)) << motion.name;
    // The image at -6.1 leaks in by 1 / (2 6.1 range), less than 1 % of the amplitude; the noise by
    // 0.2 sqrt(2 / 4000), four times.
    EXPECT_NEAR(lines[0].amplitude, 0.3, 0.003 + 0.018) << motion.name;
  }
}

/// Whatever the sensor shows while the motor stands is no line over the angle.
TEST(Lines, OverTheAngleLeaveOutAStandstill) {
  std::vector<double> angle;
  std::vector<double> e = noise(8000);
  for (std::size_t k = 0; k < e.size(); ++k) {
    const double t = 5e-4 * static_cast<double>(k);
    angle.push_back(30.0 * std::max(t, 2.0));
    e[k] = t < 2.0 ? 5.0 : 0.3 * e[k] + 0.3 * std::cos(6.1 * angle[k]);
  }
  const std::vector<SpectralLine> lines = lines_over_angle(angle, e, 50.0, 20.0, 3).strongest;
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NEAR(lines[0].frequency, 6.1, (kOff + 4.0 * deviation(0.3, 0.3, 4000.0)) * kTurn / 60.0);
  EXPECT_TRUE(
      lines_over_angle(std::vector<double>(100, 2.0), std::vector<double>(100, 1.0), 50.0, 20.0, 3)
          .strongest.empty());
}

TEST(Bands, HoldThePowerOfTheirLines) {
  std::vector<double> t;
  std::vector<double> e;
  for (std::size_t k = 0; k < 20000; ++k) {
    t.push_back(7.0 + 5e-4 * static_cast<double>(k));
    e.push_back(0.5 + 2.0 * std::cos(kTurn * 2.0 * t[k]) + 3.0 * std::sin(kTurn * 6.0 * t[k]) +
                4.0 * std::cos(kTurn * 50.0 * t[k]));
  }
  const std::vector<double> power =
      band_powers(t, e, std::vector<double>{0.0, 1.0, 3.0, 10.0, 30.0});
  ASSERT_EQ(power.size(), 4U);
  // Each line has half its square; between its own and the next edge lie ten lines and more.
  EXPECT_NEAR(power[0], 0.25, 0.01);
  EXPECT_NEAR(power[1], 2.0, 0.01);
  EXPECT_NEAR(power[2], 4.5, 0.01);
  EXPECT_NEAR(power[3], 0.0, 0.01);
}

TEST(Lines, OfNoiseAreNone) {
  std::vector<double> t;
  const std::vector<double> e = noise(8000);
  for (std::size_t k = 0; k < e.size(); ++k) t.push_back(5e-4 * static_cast<double>(k));
  // 800 independent lines, exponential: one above 20 in 6e5.
  EXPECT_TRUE(lines_over_time(t, e, 100.0, 20.0, 3).strongest.empty());
  EXPECT_TRUE(
      lines_over_time(std::vector<double>(10, 1.0), std::vector<double>(10, 1.0), 100.0, 20.0, 3)
          .strongest.empty());
}

TEST(MotorAngle, IsTheIntegralOfTheSpeedAndBridgesMissingOnes) {
  std::vector<Sample> samples;
  for (int k = 0; k <= 100; ++k) samples.push_back({0.01 * k, 0.0, 3.0});
  samples[50].y = std::nan("");
  EXPECT_NEAR(motor_angle(samples).back(), 3.0, 1e-12);
}

}  // namespace
}  // namespace armukf
