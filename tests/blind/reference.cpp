#include "reference.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace blind {
namespace {

using Speed = std::vector<double>;

constexpr double kTurn = 2.0 * std::numbers::pi;

void scale_to_peak(Speed& speed, double peak) {
  double found = 0.0;
  for (const double value : speed) found = std::max(found, std::abs(value));
  for (double& value : speed) value *= peak / found;
}

/// Lines from `lowest` to `highest` (Hz), as many as the period has, of drawn phases and of
/// amplitudes that fall as f^-fall; times 0.5 to 1.5, drawn, if `uneven`.
Speed lines(int samples, double lowest, double highest, double fall, bool uneven, double peak,
            Draw& draw) {
  const double period = samples * kSampleTime;
  Speed speed(samples, 0.0);
  const int last = static_cast<int>(highest * period);
  for (int line = static_cast<int>(std::ceil(lowest * period)); line <= last; ++line) {
    const double phase = draw.phase();
    const double amplitude = std::pow(line, -fall) * (uneven ? draw.between(0.5, 1.5) : 1.0);
    // Turned on by its step from sample to sample: a cosine each would take most of a run.
    const double step = kTurn * line / samples;
    double x = std::cos(phase);
    double y = std::sin(phase);
    for (double& value : speed) {
      value += amplitude * x;
      const double turned = x * std::cos(step) - y * std::sin(step);
      y = x * std::sin(step) + y * std::cos(step);
      x = turned;
    }
  }
  scale_to_peak(speed, peak);
  return speed;
}

void add(Speed& speed, const Speed& other) {
  for (std::size_t n = 0; n < speed.size(); ++n) speed[n] += other[n];
}

/// The periodic answer of a first-order low-pass.
Speed low_passed(const Speed& speed, double cutoff_hz) {
  const double follow = 1.0 - std::exp(-kTurn * cutoff_hz * kSampleTime);
  Speed low(speed.size());
  double value = 0.0;
  for (int pass = 0; pass < 2; ++pass)  // the second is in steady state
    for (std::size_t n = 0; n < speed.size(); ++n) low[n] = value += follow * (speed[n] - value);
  return low;
}

Speed square(int samples, double amplitude) {
  Speed speed(samples, -amplitude);
  std::fill_n(speed.begin(), samples / 2, amplitude);
  return speed;
}

/// From rest to rest: speeds of changing sign, reached at drawn accelerations and kept for a while.
Speed moves(int samples, Draw& draw) {
  Speed speed;
  double now = 0.0;
  double direction = draw.sign();
  const auto go_to = [&](double wanted, double acceleration, double keep_s) {
    const double step = std::copysign(acceleration * kSampleTime, wanted - now);
    for (; std::abs(wanted - now) > std::abs(step); now += step) speed.push_back(now);
    now = wanted;
    speed.insert(speed.end(), static_cast<std::size_t>(keep_s / kSampleTime), now);
  };
  while (static_cast<int>(speed.size()) < samples) {
    const double acceleration = draw.log_between(80.0, 500.0);  // rad/s^2
    const double wanted = direction * draw.between(5.0, 30.0);
    go_to(wanted, acceleration, draw.between(0.1, 0.7));
    if (draw.chance(0.3)) go_to(0.0, acceleration, draw.between(0.05, 0.3));
    direction = -direction;
  }
  speed.resize(samples);
  const int last = std::min(samples, 500);  // the period ends at rest
  for (int n = 0; n < last; ++n) speed[samples - 1 - n] *= static_cast<double>(n) / last;
  return speed;
}

}  // namespace

Speed reference(Motion motion, int samples, Draw& draw) {
  const double highest = draw.between(25.0, 45.0);  // Hz
  switch (motion) {
    case Motion::kSquareAndMultisine: {
      const double height = draw.between(10.0, 18.0);
      Speed speed = lines(samples, 1.0, highest, 0.0, false, height, draw);
      add(speed, low_passed(square(samples, draw.between(12.0, 22.0)), 1.0));
      return speed;
    }
    case Motion::kRandomPhase: {
      const double fall = draw.between(0.5, 1.0);
      const double height = draw.between(25.0, 38.0);
      return lines(samples, 0.15, highest, fall, true, height, draw);
    }
    case Motion::kMoves: {
      Speed speed = low_passed(moves(samples, draw), 30.0);
      const double height = draw.between(2.0, 5.0);
      add(speed, lines(samples, 2.0, highest, 0.0, false, height, draw));
      return speed;
    }
  }
  return {};
}

}  // namespace blind
