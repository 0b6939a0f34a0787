#include "armukf/batch/frequency_response.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armukf/core/dual.hpp"
#include "armukf/core/fourier.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t kLowestLine = 4;  // of the record's own frequency; below, drift
constexpr double kHighestShare = 0.25;  // of half the sample rate; masses and springs end far below
constexpr double kBandRatio = 1.26;     // a third of an octave
/// Torque times speed, of the largest: a band with less is noise in the loop, not excitation. At a
/// resonance one of the two is small, at the end of the excitation both.
constexpr double kSmallPower = 0.03;

/// The arm about rest: x' = system x + input u.
struct Linear {
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(kArmStates, kArmStates);
  Eigen::VectorXd input = Eigen::VectorXd::Zero(kArmStates);
};

Linear about_rest(const Model& model) {
  using Number = Dual<8>;
  std::array<Number, kArmParameters> p;
  for (int i = 0; i < kArmParameters; ++i) p[i] = Number(model.parameters[i].value);
  for (const int i : {kFv, kFc, kFcs}) p[i] = Number(0.0);
  std::array<Number, kArmStates> x;
  std::array<Number, kArmStates> dx{};
  for (int i = 0; i < kArmStates; ++i) x[i] = Number::variable(0.0, i);
  const Number u = Number::variable(0.0, kArmStates);
  derivative(Coefficients<Number>(p.data()), x.data(), u, dx.data());
  Linear linear;
  for (int i = 0; i < kArmStates; ++i) {
    for (int j = 0; j < kArmStates; ++j) linear.system(i, j) = dx[i].gradient[j];
    linear.input[i] = dx[i].gradient[kArmStates];
  }
  return linear;
}

/// Speeds with missing ones on the line between their neighbours.
std::vector<double> bridged_speeds(const std::vector<Sample>& samples) {
  std::vector<double> y(samples.size(), 0.0);
  std::size_t last = samples.size();  // measured; none yet
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (std::isnan(samples[k].y)) continue;
    const double from = last < samples.size() ? samples[last].y : samples[k].y;
    const std::size_t first = last < samples.size() ? last + 1 : 0;
    for (std::size_t i = first; i <= k; ++i)
      y[i] = from + (samples[k].y - from) * static_cast<double>(i + 1 - first) /
                        static_cast<double>(k + 1 - first);
    last = k;
  }
  if (last < samples.size())
    std::fill(y.begin() + static_cast<std::ptrdiff_t>(last), y.end(), samples[last].y);
  return y;
}

/// Spectrum of values without their mean, under a Hann window.
std::vector<Complex> spectrum(std::vector<double> values) {
  const auto count = static_cast<double>(values.size());
  double mean = 0.0;
  for (const double v : values) mean += v / count;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(k) / count;
    values[k] = (values[k] - mean) * (1.0 - std::cos(turn));
  }
  return fourier(values);
}

double mean_magnitude(const std::vector<Complex>& spectrum, std::size_t first, std::size_t end) {
  double sum = 0.0;
  for (std::size_t k = first; k < end; ++k) sum += std::norm(spectrum[k]);
  return std::sqrt(sum / static_cast<double>(end - first));
}

/// One past the last line of the last band that holds power.
std::size_t end_of_excitation(const std::vector<Complex>& torque,
                              const std::vector<Complex>& speed) {
  const double lines = static_cast<double>(torque.size()) * 0.5;
  const auto highest = static_cast<std::size_t>(kHighestShare * lines);
  std::vector<std::pair<double, std::size_t>> bands;  // power and end
  double largest = 0.0;
  for (std::size_t first = kLowestLine; first < highest;) {
    const auto end = static_cast<std::size_t>(std::ceil(kBandRatio * static_cast<double>(first)));
    const double power = mean_magnitude(torque, first, end) * mean_magnitude(speed, first, end);
    // The slow ends of a record hold what it drifts by: the largest is that of its middle.
    if (first > 2 * kLowestLine) largest = std::max(largest, power);
    bands.emplace_back(power, end);
    first = end;
  }
  std::size_t last = kLowestLine;
  for (const auto& [power, end] : bands)
    if (power > 0.0 && power >= kSmallPower * largest) last = end;
  return last;
}

}  // namespace

FrequencyResponse::FrequencyResponse(const Model& model) {
  // The resolvent (s I - A)^-1 = sum_k s^k M_k / D(s) by the recursion of Faddeev and LeVerrier.
  const Linear linear = about_rest(model);
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(kArmStates, kArmStates);
  Eigen::MatrixXd factor = unit;
  denominator_[kArmStates] = 1.0;
  for (int k = kArmStates - 1; k >= 0; --k) {
    numerator_[k] = factor.row(kMeasuredState).dot(linear.input);
    const Eigen::MatrixXd product = linear.system * factor;
    denominator_[k] = -product.trace() / (kArmStates - k);
    factor = product + denominator_[k] * unit;
  }
}

Complex FrequencyResponse::operator()(double w) const {
  const Complex s(0.0, w);
  Complex numerator = 0.0;
  Complex denominator = denominator_[kArmStates];
  for (int k = kArmStates - 1; k >= 0; --k) {
    numerator = numerator * s + numerator_[k];
    denominator = denominator * s + denominator_[k];
  }
  return numerator / denominator;
}

std::vector<Line> excited_lines(const Model& model, const std::vector<Sample>& samples) {
  const std::vector<double> p = model.values();
  const Coefficients<double> coefficients(p.data());
  const std::vector<double> y = bridged_speeds(samples);
  // The torque is held over an interval; its middle is half an interval after the sample.
  std::vector<double> torque(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k)
    torque[k] = samples[k].u - friction(coefficients, y[k]);
  const std::vector<Complex> torque_lines = spectrum(torque);
  const std::vector<Complex> speed_lines = spectrum(y);
  const double length = (samples.back().t - samples.front().t) *
                        static_cast<double>(samples.size()) /
                        static_cast<double>(samples.size() - 1);
  const double dt = length / static_cast<double>(samples.size());
  const std::size_t end = end_of_excitation(torque_lines, speed_lines);
  std::vector<Line> lines;
  for (std::size_t k = kLowestLine; k < end; ++k) {
    const double w = 2.0 * std::numbers::pi * static_cast<double>(k) / length;
    const Complex held = std::polar(1.0, -0.5 * w * dt);
    lines.push_back({w, held * torque_lines[k], speed_lines[k]});
  }
  return lines;
}

}  // namespace armukf
