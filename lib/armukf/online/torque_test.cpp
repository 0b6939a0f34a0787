#include "armukf/online/torque_test.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "armukf/online/session.hpp"

namespace armukf {
namespace {

constexpr double kJitter = 0.01;  // of an interval that counts as the same

/// Hz, in nearly equal ratios: what swings between two of them shakes both.
constexpr std::array kModesHz{4.0, 6.0, 8.5, 12.0, 17.0, 25.0, 35.0, 50.0};
constexpr double kModeDamping = 0.05;  // of steel with joints, rather much

double radian_rate(double hertz) { return 2.0 * std::numbers::pi * hertz; }

}  // namespace

TorqueTest::Sums& TorqueTest::Sums::operator+=(const Sums& other) {
  friction += other.friction;
  angle += other.angle;
  springs += other.springs;
  modes += other.modes;
  return *this;
}

void TorqueTest::add(const Estimate& estimate) {
  const double dt = estimate.sample.t - t_;
  if (known_ && estimate.status != Status::kGap) {
    if (!(dt > 0.0)) return;  // of a time that the session passed over
    advance(dt);
    const double innovation = estimate.innovation / estimate.innovation_sd;
    if (estimate.status == Status::kOk && watched_ > kSettled && std::isfinite(innovation))
      test(innovation);
  }
  remember(estimate);
}

/// Moves the angle and the oscillators z' = (i - damping) rate z + rate speed over dt (s), and
/// leaves sums that are too old.
void TorqueTest::advance(double dt) {
  if (!(std::abs(dt / interval_ - 1.0) < kJitter)) turn_by(dt);
  const double speed = x_[kSpeedMotor];
  angle_ += speed * dt;
  for (int i = 0; i < kModes; ++i) {
    const double a = modes_[2 * i];
    const double b = modes_[2 * i + 1];
    modes_[2 * i] =
        turns_[2 * i] * a - turns_[2 * i + 1] * b + radian_rate(kModesHz[i]) * dt * speed;
    modes_[2 * i + 1] = turns_[2 * i + 1] * a + turns_[2 * i] * b;
  }
  watched_ += dt;
  if (watched_ < next_) return;
  before_ = since_;
  since_ = {};
  next_ *= 2.0;
}

void TorqueTest::turn_by(double dt) {
  interval_ = dt;
  for (int i = 0; i < kModes; ++i) {
    const double rate = radian_rate(kModesHz[i]);
    const auto turn = std::exp(std::complex(-kModeDamping, 1.0) * rate * dt);
    turns_[2 * i] = turn.real();
    turns_[2 * i + 1] = turn.imag();
  }
}

void TorqueTest::test(double innovation) {
  const TorqueTerms terms = torque_terms(x_.data(), u_, angle_);
  since_.friction.add(terms.friction, innovation);
  since_.angle.add(terms.angle, innovation);
  since_.springs.add(terms.springs, innovation);
  since_.modes.add(modes_, innovation);
}

void TorqueTest::remember(const Estimate& estimate) {
  const auto is_number = [](double v) { return std::isfinite(v); };
  const auto states =
      estimate.values.first(std::min<std::size_t>(estimate.values.size(), kArmStates));
  known_ = states.size() == kArmStates && std::ranges::all_of(states, is_number) &&
           std::isfinite(estimate.sample.t);
  if (!known_) return;
  t_ = estimate.sample.t;
  std::ranges::copy(states, x_.begin());
  if (std::isfinite(estimate.sample.u)) u_ = estimate.sample.u;
}

TorqueTestResult TorqueTest::result() const {
  if (!has_settled()) return {};
  Sums sums = before_;
  sums += since_;
  return {sums.friction.p(), sums.angle.p(), sums.springs.p(0, kOwnTorques),
          sums.springs.p(kOwnTorques), sums.modes.p()};
}

}  // namespace armukf
