#pragma once

#include <array>

#include "armukf/core/score_test.hpp"
#include "armukf/model/arm.hpp"
#include "armukf/model/torque_terms.hpp"

namespace armukf {

struct Estimate;

/// Probabilities that chance alone makes innovations hang together as much with what a torque that
/// the model lacks would go with; 1 where too little was seen. Each is small by chance as often as
/// it says, but for `modes`, see there.
struct TorqueTestResult {
  double friction = 1.0;  // offset, friction of motor, gear box and arm
  double angle = 1.0;     // gravity
  double springs = 1.0;   // the model's own torques: masses, springs, dampers, drive
  double gaps = 1.0;      // gaps of gear and arm, given the model's own torques
  /// Oscillators between 4 and 50 Hz that the motor's speed would shake. While an estimate of the
  /// arm's own resonance still settles the innovations hold some of it, and this is small too.
  double modes = 1.0;
};

/// Tests the innovations of a filter against torques. One that changes within a second moves a
/// single innovation by a small part of its deviation, too little for their autocorrelation to
/// show, and many of them in one direction, which a sum over seconds shows. The later part of the
/// samples counts, more than their last half: what a filter finds in the first ones are its start
/// values. Memory is constant, and nothing is allocated.
class TorqueTest {
 public:
  /// The next estimate; one that does not tell what is believed is passed over.
  void add(const Estimate& estimate);
  /// One that tells nothing.
  void pass_over(const Estimate& estimate) { remember(estimate); }

  /// Whether enough was seen for any test of the innovations: before, they tell of start values.
  bool has_settled() const { return watched_ >= kSettled + kLeastTested; }

  /// All 1 before that.
  TorqueTestResult result() const;

  template <class Archive>
  void archive(Archive& archive) {
    archive(known_, t_, x_, u_, angle_, watched_, next_, interval_, modes_, before_, since_);
    if constexpr (Archive::kLoads) turn_by(interval_);
  }

 private:
  static constexpr int kModes = 8;
  using Modes = std::array<double, 2 * kModes>;  // of each oscillator both parts of its state

  /// The sums of all tests, over some samples.
  struct Sums {
    ScoreTest<6> friction;
    ScoreTest<2> angle;
    ScoreTest<8> springs;
    ScoreTest<2 * kModes> modes;

    Sums& operator+=(const Sums& other);

    template <class Archive>
    void archive(Archive& archive) {
      archive(friction, angle, springs, modes);
    }
  };

  void advance(double dt);
  void turn_by(double dt);
  void test(double innovation);
  void remember(const Estimate& estimate);

  bool known_ = false;                      // whether there was an estimate before
  double t_ = 0.0;                          // s, of the last estimate
  std::array<double, kArmStates> x_{};      // its states
  double u_ = 0.0;                          // N.m
  double angle_ = 0.0;                      // rad, of the motor, from where it was at first
  double watched_ = 0.0;                    // s, without gaps
  double next_ = kSettled;                  // s, watched, when the older half of the sums is left
  double interval_ = 0.0;                   // s, for which turns_ hold
  std::array<double, 2 * kModes> turns_{};  // of the oscillators' states in an interval
  Modes modes_{};
  Sums before_;  // from a quarter of next_ to a half of it
  Sums since_;   // from then on

  static constexpr double kSettled = 2.6;      // s: a race's two, and until its winner has settled
  static constexpr double kLeastTested = 2.0;  // s: some swings of the slowest mode
};

}  // namespace armukf
