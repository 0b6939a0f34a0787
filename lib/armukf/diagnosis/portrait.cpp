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
#include <optional>

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
constexpr int kWaves = 12;  // half periods in it of what comes and goes, at most

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

/// What a parameter may go with: courses of its changes, each at most 1 in size.
struct Course {
  std::string_view where;  // it is not the same
  Eigen::MatrixXd values;  // at each sample, a column each
};

Eigen::VectorXd scaled(const Eigen::VectorXd& values) {
  const double most = values.cwiseAbs().maxCoeff();
  return most > 0.0 ? Eigen::VectorXd(values / most) : values;
}

/// angle: of the motor, rad. The load is that of the gear's spring as the model predicts it: in the
/// commanded torque a controller answers the noise of the very sample that is predicted.
std::vector<Course> courses(const std::vector<Instant>& motion, const std::vector<double>& angle) {
  const auto course = [&](const std::function<double(const Instant&)>& value) {
    Eigen::VectorXd all(motion.size());
    for (std::size_t k = 0; k < motion.size(); ++k)
      all[static_cast<Eigen::Index>(k)] = value(motion[k]);
    return scaled(all);
  };
  const Eigen::Map<const Eigen::VectorXd> whole(angle.data(),
                                                static_cast<Eigen::Index>(angle.size()));
  const Eigen::VectorXd about = scaled(whole.array() - whole.mean());
  Eigen::MatrixXd waves(about.size(), kWaves);
  for (int j = 0; j < kWaves; ++j)
    waves.col(j) =
        course([j](const Instant& at) { return std::cos(std::numbers::pi * (j + 1) * at.share); });
  Eigen::MatrixXd over_angle(about.size(), 2);
  over_angle << about, about.cwiseAbs2();
  return {{"at all angles of the motor", over_angle},
          {"at all times", course([](const Instant& at) { return at.share; })},
          {"all the time, but comes and goes", waves},
          {"at all speeds", course([](const Instant& at) { return std::abs(at.speed); })},
          {"at all loads", course([](const Instant& at) { return std::abs(at.twist); })}};
}

/// A parameter that is not the same all along a course.
struct Changing {
  const Parameter* parameter;
  Score score;
};

/// What tells how innovations go with the parameters.
struct Sensed {
  const ScoreTest& test;
  Eigen::MatrixXd sensitivities;  // to the parameters, a column each

  Sensed(const ScoreTest& by, const std::vector<int>& parameters)
      : test(by), sensitivities(by.sensitivities_to(parameters)) {}

  Score varying(std::size_t parameter, const Course& course, double least_share) const {
    return test.varying(sensitivities.col(static_cast<Eigen::Index>(parameter)), course.values,
                        least_share);
  }
};

/// Parameters of which the records tell that they go with a course, that which explains most first:
/// by all of those tests, of which the first says how much.
std::vector<Changing> changing_along(const std::vector<Sensed>& tests, const Model& model,
                                     const std::vector<int>& parameters, const Course& course) {
  const auto tells = [&](const Score& score) {
    return score.p_value * static_cast<double>(parameters.size()) < kLevel;
  };
  std::vector<Changing> seen;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Score score = tests.front().varying(i, course, kMatters);
    if (tells(score) && std::all_of(tests.begin() + 1, tests.end(), [&](const Sensed& other) {
          return tells(other.varying(i, course, 0.0));
        }))
      seen.push_back({&model.parameters[parameters[i]], score});
  }
  std::ranges::stable_sort(seen, std::greater{}, [](const Changing& c) { return c.score.share; });
  return seen;
}

/// Of each course the parameter that goes with it most, in words, with what that would explain.
std::vector<std::pair<double, std::string>> changing(const std::vector<const ScoreTest*>& tests,
                                                     const Model& model,
                                                     const std::vector<Course>& all) {
  constexpr double kNearlyAsMuch = 0.8;
  std::vector<int> parameters = model.unknowns();
  const int inertia = model.index_of("J");
  if (std::ranges::find(parameters, inertia) == parameters.end()) parameters.push_back(inertia);
  std::vector<Sensed> sensed;
  sensed.reserve(tests.size());
  for (const ScoreTest* test : tests) sensed.emplace_back(*test, parameters);
  std::vector<std::pair<double, std::string>> told;
  for (const Course& course : all) {
    const std::vector<Changing> seen = changing_along(sensed, model, parameters, course);
    if (seen.empty()) continue;
    const auto& [parameter, score] = seen.front();
    std::vector<std::string> others;
    for (std::size_t i = 1; i < seen.size(); ++i)
      if (seen[i].score.share > kNearlyAsMuch * score.share)
        others.push_back(seen[i].parameter->name);
    const Eigen::VectorXd change =
        course.values * Eigen::Map<const Eigen::VectorXd>(score.sizes.data(), course.values.cols());
    told.emplace_back(
        score.share,
        fmt::format("{} is not the same {}, by about {:.2g} {}: explains {:.1f} % of the "
                    "innovations{}{}",
                    parameter->name, course.where, change.maxCoeff() - change.minCoeff(),
                    parameter->unit, 100.0 * score.share,
                    others.empty() ? "" : ", nearly as much as would ", fmt::join(others, " or ")));
  }
  return told;
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
                                  const Propagation& propagation,
                                  const std::vector<Gains>& likeliest) {
  const std::vector<double> innovations = one_step(fit, pieces, propagation).errors;
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
  const std::vector<double> angle = motor_angle(pieces);
  std::vector<const ScoreTest*> tests{&test};
  std::optional<ScoreTest> by_likeliest;
  if (!likeliest.empty())
    tests.push_back(&by_likeliest.emplace(fit.model, fit.x0, pieces, propagation, likeliest));
  std::ranges::move(changing(tests, fit.model, courses(motion, angle)), std::back_inserter(seen));
  std::ranges::sort(seen, std::greater{});
  std::vector<std::string> lines;
  for (const auto& [share, text] : seen)
    if (std::ranges::find(lines, text) == lines.end()) lines.push_back(text);
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
