#include "armukf/diagnosis/portrait.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>

#include "armukf/batch/pieces.hpp"
#include "armukf/diagnosis/score.hpp"
#include "armukf/diagnosis/sensor_faults.hpp"
#include "armukf/diagnosis/spectrum.hpp"

namespace armukf {
namespace {

constexpr double kLevel = 1e-4;        // of a probe's test
constexpr double kMatters = 0.005;     // of the squared innovations, most of which are noise
constexpr double kOutstanding = 40.0;  // beside its neighbourhood
constexpr double kHighestHz = 100.0;
constexpr int kBlocks = 4;  // of the record's time

/// What the motor does at a sample, as the model says.
struct Instant {
  double share;     // of the record's time, 0 to 1
  double time;      // s
  double speed;     // rad/s
  double torque;    // N.m, commanded
  double sign;      // of the speed, smooth
  double reversal;  // -1 to 1: bends with the motion, as dry friction does before it slips
  double twist;     // rad, of the gear's spring
};

/// A torque that might act on the motor, as columns of what it could be made of.
struct Probe {
  std::string description;
  int columns;
  std::function<double(const Instant&, int)> torque;
  double looks = 1.0;  // torques of which it is the most conspicuous one
};

double in_block(const Instant& at, int block) {
  return std::min(kBlocks - 1, static_cast<int>(at.share * kBlocks)) == block ? 1.0 : 0.0;
}

std::vector<Probe> probes() {
  return {
      {"a torque that is not the same in all parts of the record (offset or drift)", kBlocks,
       [](const Instant& at, int j) { return in_block(at, j); }},
      {"friction that is not the same in all parts of the record", kBlocks,
       [](const Instant& at, int j) { return in_block(at, j) * at.sign; }},
      {"a torque that depends on the motor's speed in another way than its friction does", 4,
       [](const Instant& at, int j) {
         const double w = at.speed / 30.0;
         return std::array{w, w * std::abs(w), at.sign, at.sign / (1.0 + w * w * 25.0)}[j];
       }},
      {"a torque that differs between the directions", 2,
       [](const Instant& at, int j) { return j == 0 ? 1.0 : std::abs(at.speed) / 30.0; }},
      {"a torque that is not proportional to the command (saturation, gain)", 2,
       [](const Instant& at, int j) {
         return j == 0 ? at.torque : at.torque * at.torque * at.torque / 100.0;
       }},
      {"friction that grows with the load", 1,
       [](const Instant& at, int /*j*/) { return std::abs(at.torque) * at.sign; }},
      // beside the straight and cubic parts that the model has
      {"a torque of the gear's spring that is not as its law says", 3,
       [](const Instant& at, int j) {
         constexpr double kTouching = 0.01;  // rad
         return std::array{at.twist * std::abs(at.twist), at.twist * at.twist,
                           at.twist / std::hypot(at.twist, kTouching)}[j];
       }},
      {"a torque that remembers reversals (hysteresis, presliding)", 1,
       [](const Instant& at, int /*j*/) { return at.reversal; }},
  };
}

/// states: as the model predicts them, since what is measured brings its noise.
std::vector<Instant> instants(const std::vector<Record>& pieces,
                              const std::vector<std::vector<double>>& states) {
  constexpr double kSlip = 0.1;  // rad, after which dry friction slips
  const std::vector<double> times = times_of(pieces);
  std::vector<Instant> all;
  for (const Record& piece : pieces) {
    double bent = 0.0;
    double last = piece.samples.front().t;
    for (const Sample& s : piece.samples) {
      const std::vector<double>& x = states[all.size()];
      const double speed = x[kSpeedMotor];
      bent = std::clamp(bent + speed * (s.t - last) / kSlip, -1.0, 1.0);
      last = s.t;
      const double time = times[all.size()];
      all.push_back({time / times.back(), time, speed, s.u, std::tanh(speed / kStandstill), bent,
                     x[kTwistGear]});
    }
  }
  return all;
}

Eigen::MatrixXd torques_of(const Probe& probe, const std::vector<Instant>& motion) {
  Eigen::MatrixXd torques(motion.size(), probe.columns);
  for (std::size_t k = 0; k < motion.size(); ++k)
    for (int j = 0; j < probe.columns; ++j)
      torques(static_cast<Eigen::Index>(k), j) = probe.torque(motion[k], j);
  return torques;
}

/// A periodic torque of that frequency, picked from as many.
Probe line_probe(double hertz, int looked_at) {
  const double w = 2.0 * std::numbers::pi * hertz;
  return {fmt::format("a periodic torque at {:.2f} Hz", hertz), 2,
          [w](const Instant& at, int j) {
            return j == 0 ? std::cos(w * at.time) : std::sin(w * at.time);
          },
          static_cast<double>(looked_at)};
}

/// Innovations, turned over where the motor turns back: of friction that is not the same at all
/// angles they repeat as those of a torque do.
std::vector<double> along_motion(std::vector<double> innovations,
                                 const std::vector<Instant>& motion) {
  for (std::size_t k = 0; k < innovations.size(); ++k) innovations[k] *= motion[k].sign;
  return innovations;
}

std::string bands(const FittedModel& fit, const std::vector<double>& t) {
  constexpr std::array kEdges{0.0, 1.0, 3.0, 10.0, 30.0};  // Hz
  double total = 0.0;
  double count = 0.0;
  for (const double r : fit.residual)
    if (std::isfinite(r)) total += (r * r - total) / ++count;
  const std::vector<double> power = band_powers(t, fit.residual, kEdges);
  double rest = total;
  std::vector<std::string> parts;
  for (std::size_t b = 0; b < power.size(); ++b) {
    rest -= power[b];
    parts.push_back(
        fmt::format("{:g}-{:g} Hz {:.0f} %", kEdges[b], kEdges[b + 1], 100.0 * power[b] / total));
  }
  parts.push_back(fmt::format("above {:.0f} %", 100.0 * std::max(0.0, rest) / total));
  return fmt::format("size {:.3g} rad/s rms; by band: {}", std::sqrt(total),
                     fmt::join(parts, ", "));
}

}  // namespace

std::vector<std::string> portrait(const FittedModel& fit, const std::vector<Record>& pieces,
                                  const std::vector<double>& innovations,
                                  const Propagation& propagation) {
  const ScoreTest test(fit.model, fit.x0, pieces, propagation);
  const std::vector<Instant> motion = instants(pieces, test.states());
  std::vector<Probe> tried = probes();
  const std::vector<double> t = times_of(pieces);
  for (const std::vector<double>& e : {fit.residual, innovations}) {
    const SpectralLines found = lines_over_time(t, e, kHighestHz, kOutstanding, kMostLines);
    for (const SpectralLine& line : found.strongest)
      tried.push_back(line_probe(line.frequency, found.looked_at));
  }
  std::vector<std::pair<double, std::string>> seen;
  for (const Probe& probe : tried) {
    const Score score = test(torques_of(probe, motion));
    if (score.p_value * probe.looks < kLevel && score.share > kMatters)
      seen.emplace_back(score.share, fmt::format("{}: explains {:.1f} % of the innovations",
                                                 probe.description, 100.0 * score.share));
  }
  std::ranges::sort(seen, std::greater{});
  std::vector<std::string> lines;
  for (const auto& [share, text] : seen)
    if (std::ranges::find(lines, text) == lines.end()) lines.push_back(text);
  const std::vector<double> angle = motor_angle(pieces);
  const auto repeats = [&](std::string_view what, const std::vector<double>& e) {
    for (const SpectralLine& line :
         lines_over_angle(angle, e, kHighestHarmonic, kOutstanding, kMostLines).strongest)
      lines.push_back(fmt::format("{} with the motor's angle, {:.2f} times per rad", what,
                                  line.frequency / (2.0 * std::numbers::pi)));
  };
  repeats("repeats", innovations);
  repeats("friction that repeats", along_motion(innovations, motion));
  std::ranges::move(sensor_faults(pieces, innovations), std::back_inserter(lines));
  if (!lines.empty()) lines.push_back(bands(fit, t));
  return lines;
}

}  // namespace armukf
