#include "armukf/diagnosis/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "armukf/core/fourier.hpp"

namespace armukf {
namespace {

constexpr int kNeighbours = 25;       // lines to either side that tell a line's neighbourhood
constexpr int kOversampling = 2;      // lines per resolution
constexpr int kRefinement = 2;        // lines that the search for a peak's place amounts to
constexpr double kFewestTurns = 1.5;  // of a frequency in the range; less is no repetition
constexpr double kTurn = 2.0 * std::numbers::pi;

/// Lowest and highest of the places.
struct Range {
  explicit Range(std::span<const double> x) {
    const auto [least, most] = std::ranges::minmax(x);
    low = least;
    length = most - least;
  }
  double low;
  double length;
};

/// |sum v_k exp(-i j step x_k)|^2 for j = 0 ... last. Each value is laid on the four points of a
/// uniform mesh around its place, by the weights with which a cubic through them interpolates
/// there; the transform of the mesh is quick. The mesh has 16 points or more in the shortest
/// period: what the cubic errs by is below 1e-3 of a value. Source: W. H. Press, G. B. Rybicki,
/// Astrophysical Journal 338 (1989).
std::vector<double> powers_at(std::span<const double> x, std::span<const double> v, double low,
                              double step, int last) {
  constexpr std::size_t kPointsInPeriod = 16;
  const std::size_t length = quick_length(kPointsInPeriod * static_cast<std::size_t>(last + 1));
  const double points_per_unit = static_cast<double>(length) * step / kTurn;
  std::vector<double> mesh(length, 0.0);
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double place = (x[k] - low) * points_per_unit;
    const auto i = static_cast<std::size_t>(place);
    const double s = place - static_cast<double>(i);
    // The first point's neighbour is the last one: whole turns of every line lie between them.
    mesh[(i + length - 1) % length] += v[k] * s * (1.0 - s) * (s - 2.0) / 6.0;
    mesh[i % length] += v[k] * (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0;
    mesh[(i + 1) % length] += v[k] * (s + 1.0) * s * (2.0 - s) / 2.0;
    mesh[(i + 2) % length] += v[k] * (s + 1.0) * s * (s - 1.0) / 6.0;
  }
  std::vector<double> power = powers(mesh, length);
  power.resize(static_cast<std::size_t>(last) + 1);
  return power;
}

/// The mean power around line i, without the constant; by the median, since a strong line is no
/// noise.
double neighbourhood(const std::vector<double>& power, int i) {
  const int from = std::max(1, i - kNeighbours);
  const int to = std::min(static_cast<int>(power.size()), i + kNeighbours + 1);
  std::vector<double> around(power.begin() + from, power.begin() + to);
  const auto middle = around.begin() + static_cast<int>(around.size() / 2);
  std::ranges::nth_element(around, middle);
  return *middle / std::numbers::ln2;
}

/// Where between the lines the peak at line i is highest: by a parabola through the logarithms of
/// the line and its neighbours, to 2 % of the resolution.
double place_of_peak(const std::vector<double>& power, int i) {
  const double before = std::log(power[i - 1]);
  const double behind = std::log(power[i + 1]);
  const double bend = before - 2.0 * std::log(power[i]) + behind;
  return std::isfinite(bend) && bend < 0.0 ? i + 0.5 * (before - behind) / bend : i;
}

/// Values that count by their weights; 0 where one is missing.
struct Weighted {
  Weighted(std::span<const double> e, const std::vector<double>& weights) {
    for (std::size_t k = 0; k < e.size(); ++k) {
      const bool there = std::isfinite(e[k]);
      values.push_back(there ? weights[k] * e[k] : 0.0);
      weight += there ? weights[k] : 0.0;
      count += there;
    }
  }
  std::vector<double> values;
  double weight = 0.0;
  int count = 0;
};

double amplitude_at(double w, std::span<const double> x, const Weighted& e) {
  std::complex<double> sum;
  for (std::size_t k = 0; k < x.size(); ++k) sum += std::polar(1.0, -w * x[k]) * e.values[k];
  return 2.0 * std::abs(sum) / e.weight;
}

/// Lines at w = step, 2 step, ... up to `highest`.
SpectralLines lines(std::span<const double> x, const Weighted& e, double highest,
                    double least_power, int most) {
  const Range range(x);
  if (!(range.length > 0.0)) return {};
  const double step = kTurn / range.length / kOversampling;
  const int first = static_cast<int>(std::ceil(kFewestTurns * kOversampling));
  const int last = static_cast<int>(std::min(highest / step, kOversampling * e.count / 2.0));
  if (last <= first) return {};
  const std::vector<double> power = powers_at(x, e.values, range.low, step, last);
  SpectralLines found{{}, kRefinement * (last - first)};
  for (int i = first; i < last; ++i) {
    if (!(power[i] >= power[i - 1] && power[i] > power[i + 1])) continue;
    const double mean = neighbourhood(power, i);
    if (power[i] > least_power * mean)
      found.strongest.push_back({step * place_of_peak(power, i), 0.0, power[i] / mean});
  }
  std::ranges::sort(found.strongest, std::greater{}, &SpectralLine::power);
  if (static_cast<int>(found.strongest.size()) > most) found.strongest.resize(most);
  for (SpectralLine& line : found.strongest) line.amplitude = amplitude_at(line.frequency, x, e);
  return found;
}

/// Half the way from the sample before to the one behind, forth or back. No more than the shortest
/// period: what lies between is not told, and a gap must not outweigh the record.
std::vector<double> ways(std::span<const double> x, double shortest_period) {
  std::vector<double> way(x.size(), 0.0);
  for (std::size_t k = 1; k < x.size(); ++k) {
    const double half = 0.5 * std::min(std::abs(x[k] - x[k - 1]), shortest_period);
    way[k - 1] += half;
    way[k] += half;
  }
  return way;
}

}  // namespace

SpectralLines lines_over_time(std::span<const double> t, std::span<const double> e,
                              double highest_hz, double least_power, int most) {
  const Weighted alike(e, std::vector<double>(t.size(), 1.0));
  SpectralLines found = lines(t, alike, kTurn * highest_hz, least_power, most);
  for (SpectralLine& line : found.strongest) line.frequency /= kTurn;
  return found;
}

SpectralLines lines_over_angle(std::span<const double> angle, std::span<const double> e,
                               double highest, double least_power, int most) {
  return lines(angle, Weighted(e, ways(angle, kTurn / highest)), highest, least_power, most);
}

std::vector<double> band_powers(std::span<const double> t, std::span<const double> e,
                                std::span<const double> edges_hz) {
  std::vector<double> bands(edges_hz.size() - 1, 0.0);
  const Range range(t);
  if (!(range.length > 0.0)) return bands;
  const Weighted values(e, std::vector<double>(t.size(), 1.0));
  const int last = static_cast<int>(std::min(edges_hz.back() * range.length, values.count / 2.0));
  const std::vector<double> power =
      powers_at(t, values.values, range.low, kTurn / range.length, last);
  const double scale = 1.0 / (values.weight * values.weight);
  for (int i = 0; i <= last; ++i) {
    const auto above = std::ranges::upper_bound(edges_hz, i / range.length);
    if (above == edges_hz.begin() || above == edges_hz.end()) continue;
    bands[above - edges_hz.begin() - 1] += (i == 0 ? 1.0 : 2.0) * power[i] * scale;
  }
  return bands;
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
