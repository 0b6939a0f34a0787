#include "recording.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <iomanip>
#include <stdexcept>

#include "draw.hpp"

namespace blind {
namespace {

constexpr int kSubsteps = 4;
constexpr double kRunIn = 3.0;               // s, after which little of the start is left
constexpr double kLongestAddedDelay = 0.05;  // s
constexpr double kRunaway = 1000.0;          // rad/s, that no stable loop reaches
constexpr double kLimit = 30.0;              // N.m, of the command
constexpr double kMostAtLimit = 0.1;         // of the samples; a loop beyond it hunts
constexpr double kDropoutSamples = 8.0;      // mean length

class Noise {
 public:
  Noise(ColouredNoise noise, double factor, Draw draw)
      : pole_(noise.pole), sd_(factor * noise.sd), draw_(draw), value_(sd_ * draw_.normal()) {}
  double next() {
    value_ = pole_ * value_ + std::sqrt(1.0 - pole_ * pole_) * sd_ * draw_.normal();
    return value_;
  }

 private:
  double pole_;
  double sd_;
  Draw draw_;
  double value_;
};

/// The last value stands while counts are lost; what arrives comes in whole counts.
class Counts {
 public:
  Counts(const Effects& effects, Draw draw) : e_(effects), draw_(draw) {}
  double seen(double speed) {
    const double begins = e_.dropout_share / (1.0 - e_.dropout_share) / kDropoutSamples;
    lost_ = draw_.chance(lost_ ? 1.0 - 1.0 / kDropoutSamples : begins);
    if (!lost_) last_ = e_.quantum > 0.0 ? e_.quantum * std::round(speed / e_.quantum) : speed;
    return last_;
  }

 private:
  const Effects& e_;
  Draw draw_;
  bool lost_ = false;
  double last_ = 0.0;
};

class SpeedLoop {
 public:
  explicit SpeedLoop(const Controller& controller) : c_(controller) {}
  double torque(double wanted_speed, double y) {
    filtered_ += (1.0 - std::exp(-kSampleTime / std::max(c_.filter_time, 1e-9))) * (y - filtered_);
    const double error = wanted_speed - filtered_;
    const double wanted = c_.proportional * error + integral_;
    if (std::abs(wanted) < kLimit)
      integral_ += c_.proportional / c_.integral_time * kSampleTime * error;
    return std::clamp(wanted, -kLimit, kLimit);
  }

 private:
  Controller c_;
  double filtered_ = 0.0;
  double integral_ = 0.0;
};

/// Commands held for a sample each, seen through a delay that need not be whole samples.
class DelayLine {
 public:
  DelayLine(double delay, double longest) : delay_(delay / kSampleTime) {
    held_.assign(static_cast<std::size_t>(longest / kSampleTime) + 2, 0.0);
  }
  void become(double delay) { delay_ = delay / kSampleTime; }
  void hold(double u) {
    held_.push_front(u);
    held_.pop_back();
  }
  /// Mean of the delayed command from `from` to `to`, parts of the sample that is being held.
  double mean(double from, double to) const {
    const double begin = from - delay_;
    const double end = to - delay_;
    const double edge = std::clamp(std::ceil(begin), begin, end);  // at most one within
    return (at(0.5 * (begin + edge)) * (edge - begin) + at(0.5 * (edge + end)) * (end - edge)) /
           (end - begin);
  }

 private:
  double at(double time) const {  // in samples, at most 1
    const int age = static_cast<int>(-std::floor(time));
    return held_[static_cast<std::size_t>(std::clamp(age, 0, static_cast<int>(held_.size()) - 1))];
  }
  double delay_;  // samples
  std::deque<double> held_;
};

void refuse_hunting(const std::vector<Sample>& samples) {
  const auto at_limit = std::ranges::count_if(
      samples, [](const Sample& sample) { return std::abs(sample.u) >= kLimit; });
  if (static_cast<double>(at_limit) > kMostAtLimit * static_cast<double>(samples.size()))
    throw std::runtime_error("the speed loop hunts");
}

}  // namespace

Record recorded(const World& world, const Effects& effects, Use use, double duration,
                double noise_factor, const std::vector<Change>& changes, double period) {
  const auto stream = static_cast<std::uint64_t>(use);
  Draw plan(world.seed, 10 + stream);
  Noise sensor(world.sensor, noise_factor, Draw(world.noise_seed, 20 + stream));
  Noise torque(world.torque, noise_factor, Draw(world.noise_seed, 30 + stream));
  Counts counts(effects, Draw(world.seed, 40 + stream));
  Record record{use == Use::kTest ? world.test_motion : world.motion, {}, {}};

  const int samples = static_cast<int>(std::lround(duration / kSampleTime));
  const std::vector<double> speed =
      reference(record.motion,
                period > 0.0 ? static_cast<int>(std::lround(period / kSampleTime)) : samples, plan);
  const int repeats = static_cast<int>(speed.size());
  const int run_in = static_cast<int>(std::lround(kRunIn / kSampleTime));
  Arm arm(world.arm, effects, duration, plan.phase());
  Machine machine{world.arm, {}};
  DelayLine delay(effects.input_delay, effects.input_delay + kLongestAddedDelay);
  SpeedLoop loop(world.controller);
  for (int n = -run_in; n < samples; ++n) {
    if (!changes.empty() && n >= 0) {
      machine = changed(world.arm, changes, n * kSampleTime);
      arm.become(machine.arm);
      delay.become(effects.input_delay + machine.wiring.input_delay);
    }
    const Wiring& wiring = machine.wiring;
    const double y = counts.seen(wiring.sensor_gain * (arm.measured_speed() + sensor.next()) +
                                 wiring.sensor_bias);
    if (!(std::abs(y) < kRunaway)) throw std::runtime_error("the speed loop is unstable");
    const double u = loop.torque(speed[((n % repeats) + repeats) % repeats], y);
    if (n == 0) record.start = arm.state();
    if (n >= 0) record.samples.push_back({u, y});
    delay.hold(u);
    const double disturbance = torque.next();
    for (int i = 0; i < kSubsteps; ++i) {
      constexpr double kPart = 1.0 / kSubsteps;
      arm.advance((n + i * kPart) * kSampleTime, kPart * kSampleTime,
                  wiring.torque_gain * delay.mean(i * kPart, (i + 1) * kPart),
                  disturbance + wiring.torque_bias);
    }
  }
  refuse_hunting(record.samples);
  return record;
}

void write_csv(const std::string& path, const std::vector<Sample>& samples) {
  std::ofstream file(path);
  file << "t,u,y\n" << std::setprecision(10);
  for (std::size_t n = 0; n < samples.size(); ++n)
    file << static_cast<double>(n) * kSampleTime << ',' << samples[n].u << ',' << samples[n].y
         << '\n';
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace blind
