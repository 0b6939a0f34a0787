#include "recording.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <stdexcept>

#include "draw.hpp"

namespace blind {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kSubsteps = 8;
constexpr double kShortestRunIn = 9.0;  // s, after which the start has died away
constexpr double kRunaway = 1000.0;     // rad/s, that no stable loop reaches

constexpr double kLowestLine = 1.0;        // Hz
constexpr double kHighestLine = 40.0;      // Hz
constexpr double kMultisinePeak = 16.0;    // rad/s
constexpr double kSquareAmplitude = 20.0;  // rad/s
constexpr double kSquareCutoff = 1.0;      // Hz

/// PI control of the speed, with a limit of the torque at which the integral rests.
struct Controller {
  double proportional;  // N.m.s/rad
  double integral;      // N.m/rad
  double operator()(double error, double& memory) const {
    constexpr double kLimit = 30.0;  // N.m
    const double wanted = proportional * error + memory;
    if (std::abs(wanted) < kLimit) memory += integral * kSampleTime * error;
    return std::clamp(wanted, -kLimit, kLimit);
  }
};
constexpr std::array<Controller, kControllers> kGains{{{4.0, 40.0}, {2.0, 15.0}, {5.5, 90.0}}};

/// One period of the speed to follow, rad/s.
std::vector<double> reference(int samples, Draw& phases) {
  const double period = samples * kSampleTime;
  std::vector<double> speed(samples, 0.0);
  const int last = static_cast<int>(kHighestLine * period);
  for (int line = static_cast<int>(std::ceil(kLowestLine * period)); line <= last; ++line) {
    const double phase = phases.between(0.0, kTurn);
    for (int n = 0; n < samples; ++n) speed[n] += std::cos(kTurn * line * n / samples + phase);
  }
  double peak = 0.0;
  for (const double value : speed) peak = std::max(peak, std::abs(value));
  for (double& value : speed) value *= kMultisinePeak / peak;

  // Second pass in the steady state of the low-pass.
  const double follow = 1.0 - std::exp(-kTurn * kSquareCutoff * kSampleTime);
  double low = 0.0;
  for (int n = 0; n < 2 * samples; ++n) {
    low += follow * ((n % samples < samples / 2 ? 1.0 : -1.0) - low);
    if (n >= samples) speed[n - samples] += kSquareAmplitude * low;
  }
  return speed;
}

/// Commands held for a sample each, seen through a delay that need not be whole samples.
class DelayLine {
 public:
  explicit DelayLine(double delay) : delay_(delay / kSampleTime) {
    held_.assign(static_cast<std::size_t>(delay_) + 2, 0.0);
  }
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

}  // namespace

std::vector<Sample> recorded(const Setting& setting, std::uint64_t stream) {
  Draw phases(setting.seed, 10 + stream);
  Draw noise(setting.seed, 20 + stream);
  const int samples = static_cast<int>(std::lround(setting.duration / kSampleTime));
  const std::vector<double> speed = reference(samples, phases);
  const int run_in = samples * static_cast<int>(std::ceil(kShortestRunIn / setting.duration));
  Arm arm(drawn_arm(setting.arm), setting.effects, setting.duration, phases.between(0.0, kTurn));
  DelayLine delay(setting.effects.input_delay);
  const Controller& control = kGains[static_cast<std::size_t>(setting.controller)];
  const double fresh = std::sqrt(1.0 - setting.noise_pole * setting.noise_pole);

  std::vector<Sample> record;
  double memory = 0.0;
  double coloured = noise.normal();
  for (int n = -run_in; n < samples; ++n) {
    coloured = setting.noise_pole * coloured + fresh * noise.normal();
    const double y = arm.measured_speed() + setting.noise * coloured;
    if (!(std::abs(y) < kRunaway)) throw std::runtime_error("the speed loop is unstable");
    const double u = control(speed[(n + run_in) % samples] - y, memory);
    if (n >= 0) record.push_back({u, y});
    delay.hold(u);
    for (int i = 0; i < kSubsteps; ++i) {
      constexpr double kPart = 1.0 / kSubsteps;
      arm.advance((n + i * kPart) * kSampleTime, kPart * kSampleTime,
                  delay.mean(i * kPart, (i + 1) * kPart));
    }
  }
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
