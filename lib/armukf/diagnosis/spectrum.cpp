#include "armukf/diagnosis/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace armukf {
namespace {

constexpr int kNeighbours = 25;       // lines to either side that tell a line's neighbourhood
constexpr int kOversampling = 2;      // lines per resolution
constexpr double kFewestTurns = 1.5;  // of a frequency in the range; less is no repetition

/// |sum e_k exp(-i w x_k)|^2 of the finite e at w = step, 2 step, ... last step, by turning each
/// phasor on.
std::vector<double> powers(std::span<const double> x, std::span<const double> e, double step,
                           int last) {
  std::vector<double> re;
  std::vector<double> im;
  std::vector<double> turn_re;
  std::vector<double> turn_im;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(e[k])) continue;
    re.push_back(e[k]);
    im.push_back(0.0);
    turn_re.push_back(std::cos(step * x[k]));
    turn_im.push_back(-std::sin(step * x[k]));
  }
  std::vector<double> power;
  for (int i = 1; i <= last; ++i) {
    double sum_re = 0.0;
    double sum_im = 0.0;
    for (std::size_t k = 0; k < re.size(); ++k) {
      const double next = re[k] * turn_re[k] - im[k] * turn_im[k];
      im[k] = re[k] * turn_im[k] + im[k] * turn_re[k];
      re[k] = next;
      sum_re += re[k];
      sum_im += im[k];
    }
    power.push_back(sum_re * sum_re + sum_im * sum_im);
  }
  return power;
}

/// Lines at w = step, 2 step, ... up to `highest`.
std::vector<SpectralLine> lines(std::span<const double> x, std::span<const double> e,
                                double highest, double least_power, int most) {
  const auto [low, high] = std::ranges::minmax(x);
  const double range = high - low;
  if (!(range > 0.0)) return {};
  const double step = 2.0 * std::numbers::pi / range / kOversampling;
  const int first = static_cast<int>(std::ceil(kFewestTurns * kOversampling));
  const int last = static_cast<int>(highest / step);
  if (last <= first) return {};
  std::vector<double> power = powers(x, e, step, last);
  power.erase(power.begin(), power.begin() + (first - 1));
  const auto count =
      static_cast<double>(std::ranges::count_if(e, [](double v) { return std::isfinite(v); }));
  std::vector<SpectralLine> found;
  const int n = static_cast<int>(power.size());
  for (int i = 0; i < n; ++i) {
    const bool peak =
        (i == 0 || power[i] >= power[i - 1]) && (i == n - 1 || power[i] > power[i + 1]);
    if (!peak) continue;
    const int from = std::max(0, i - kNeighbours);
    std::vector<double> around(power.begin() + from,
                               power.begin() + std::min(n, i + kNeighbours + 1));
    std::ranges::nth_element(around, around.begin() + static_cast<int>(around.size() / 2));
    const double mean = around[around.size() / 2] / std::numbers::ln2;
    if (power[i] > least_power * mean)
      found.push_back({(first + i) * step, 2.0 * std::sqrt(power[i]) / count, power[i] / mean});
  }
  std::ranges::sort(found, std::greater{}, &SpectralLine::power);
  if (static_cast<int>(found.size()) > most) found.resize(most);
  return found;
}

}  // namespace

std::vector<SpectralLine> lines_over_time(std::span<const double> t, std::span<const double> e,
                                          double highest_hz, double least_power, int most) {
  const double turn = 2.0 * std::numbers::pi;
  std::vector<SpectralLine> found = lines(t, e, turn * highest_hz, least_power, most);
  for (SpectralLine& line : found) line.frequency /= turn;
  return found;
}

std::vector<SpectralLine> lines_over_angle(std::span<const double> angle, std::span<const double> e,
                                           double highest, double least_power, int most) {
  return lines(angle, e, highest, least_power, most);
}

std::vector<double> motor_angle(const std::vector<Sample>& samples) {
  std::vector<double> angle;
  double at = 0.0;
  double speed = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double last = speed;
    if (!std::isnan(samples[k].y)) speed = samples[k].y;
    if (k > 0) at += 0.5 * (last + speed) * (samples[k].t - samples[k - 1].t);
    angle.push_back(at);
  }
  return angle;
}

std::vector<double> motor_angle(const std::vector<Record>& pieces) {
  std::vector<double> all;
  for (const Record& piece : pieces) {
    const double begin = all.empty() ? 0.0 : all.back();
    for (const double angle : motor_angle(piece.samples)) all.push_back(begin + angle);
  }
  return all;
}

}  // namespace armukf
