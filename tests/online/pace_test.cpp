#include "armukf/online/pace.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace armukf {
namespace {

constexpr double kUsual = 2.0;        // of the first unknown; of the second, a tenth of that
constexpr double kShownNoise = 0.2;   // of a measurement a second, in usual sizes
constexpr double kDriftBegin = 60.0;  // s

std::vector<Changeable> two_unknowns() {
  return {{nullptr, 3, "k_g3", "N.m/rad^3", kUsual, 10.0, 1.0},
          {nullptr, 1, "a_g", "-", 0.1 * kUsual, 10.0, 1.0}};
}

/// Two constants, each measured once a second, and a Kalman filter of them that reckons with a
/// walk.
class TwoConstants {
 public:
  explicit TwoConstants(unsigned seed) : random_(seed), what_(two_unknowns()) {
    belief_.values.assign(kMaxParameters, 0.0);
    belief_.belief.covariance = SquareMatrix(2);
    for (int i = 0; i < 2; ++i) belief_.belief.covariance(i, i) = std::pow(what_[i].usual, 2);
  }

  /// A second on, to t (s); the first unknown is `truth` of its usual size, the second 0.
  void step(double t, double truth) {
    belief_.t = t;
    SquareMatrix& P = belief_.belief.covariance;
    for (int i = 0; i < 2; ++i) {
      const double usual = what_[i].usual;
      const double sd = kShownNoise * usual;
      const double shown = (i == 0 ? truth * usual : 0.0) + sd * normal_(random_);
      P(i, i) += walk() * usual * usual;
      const double gain = P(i, i) / (P(i, i) + sd * sd);
      double& value = belief_.values[what_[i].parameter];
      value += gain * (shown - value);
      P(i, i) *= 1.0 - gain;
    }
    if (learns_) pace_.look(belief_, what_);
  }
  void learn() { learns_ = true; }

  double walk() const { return pace_.variance(); }
  /// How far the first one is off, in deviations.
  double off(double truth) const {
    return (belief_.values[what_[0].parameter] - truth * what_[0].usual) /
           std::sqrt(belief_.belief.covariance(0, 0));
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<Changeable> what_;
  PastBelief belief_;
  Pace pace_;
  bool learns_ = false;
};

constexpr double kLeastWalk = Pace::kLeast * Pace::kLeast;

TEST(Pace, StaysSlowWhereNothingMoves) {
  double most = 0.0;
  double sum = 0.0;
  constexpr int kRepeats = 20;
  constexpr int kSteps = 300;
  for (unsigned seed = 1; seed <= kRepeats; ++seed) {
    TwoConstants filter(seed);
    filter.learn();
    for (int k = 1; k <= kSteps; ++k) {
      filter.step(k, 0.0);
      most = std::max(most, filter.walk());
      sum += filter.walk();
    }
  }
  EXPECT_LT(sum / (kRepeats * kSteps), 1.5 * kLeastWalk);
  EXPECT_LT(most, 10.0 * kLeastWalk);
}

/// By its usual size in 40 s: whoever does not expect that is far behind, and sure of it.
TEST(Pace, FollowsWhatDriftsFast) {
  constexpr double kRate = 0.025;  // 1/s, of the usual size
  for (unsigned seed = 1; seed <= 10; ++seed) {
    TwoConstants filter(seed);
    TwoConstants slow(seed);
    filter.learn();
    double truth = 0.0;
    for (int k = 1; k <= 120; ++k) {
      truth = kRate * std::max(0.0, k - kDriftBegin);
      filter.step(k, truth);
      slow.step(k, truth);
    }
    EXPECT_LT(std::abs(filter.off(truth)), 4.0) << seed;
    EXPECT_GT(std::abs(slow.off(truth)), 8.0) << seed;  // or this test could not fail
    const double fast = filter.walk();
    for (int k = 121; k <= 240; ++k) filter.step(k, truth);
    EXPECT_LT(filter.walk(), 0.1 * fast) << seed;
    EXPECT_LT(std::abs(filter.off(truth)), 4.0) << seed;
  }
}

/// A new belief is no move.
TEST(Pace, CountsNoMoveAcrossARestart) {
  std::vector<Changeable> what = two_unknowns();
  PastBelief belief;
  belief.values.assign(kMaxParameters, 0.0);
  belief.belief.covariance = SquareMatrix(2);
  for (int i = 0; i < 2; ++i) belief.belief.covariance(i, i) = 1e-4;
  const auto walk_after = [&](bool restarts) {
    Pace pace;
    for (int k = 0; k < 8; ++k) {
      belief.t = Pace::kStretchS * k;
      belief.values[what[0].parameter] = k;
      if (restarts) pace.restart();
      pace.look(belief, what);
    }
    return pace.variance();
  };
  EXPECT_EQ(walk_after(true), kLeastWalk);
  EXPECT_GT(walk_after(false), 100.0 * kLeastWalk);
}

}  // namespace
}  // namespace armukf
