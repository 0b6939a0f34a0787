#include "armukf/filter/noise_spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace armukf {
namespace {

// Beyond these a torque's noise is a bias, and a sensor's cannot be told from a white torque.
constexpr double kLargestKickPole = 0.95;
constexpr double kLargestSensorPole = 0.95;

// rad/s: less than any sensor shows, and more than rounding leaves of a belief in double precision.
constexpr double kLeastSensor = 1e-5;
constexpr double kLeastKick = 1e-9;

double denominator(double pole, double cosine) { return 1.0 - 2.0 * pole * cosine + pole * pole; }

/// ln f at a frequency of that cosine, and its derivatives with respect to the point.
struct Density {
  double value;
  std::array<double, 4> slope;  // of ln f

  Density(const std::array<double, 4>& p, double cosine) {
    const double kick = std::exp(2.0 * p[0]) * (1.0 - p[1] * p[1]) / denominator(p[1], cosine);
    const double sensor = 2.0 * (1.0 - cosine) * std::exp(2.0 * p[2]) * (1.0 - p[3] * p[3]) /
                          denominator(p[3], cosine);
    value = kick + sensor;
    const auto pole_slope = [&](double pole) {
      return -2.0 * pole / (1.0 - pole * pole) - 2.0 * (pole - cosine) / denominator(pole, cosine);
    };
    slope = {2.0 * kick / value, kick * pole_slope(p[1]) / value, 2.0 * sensor / value,
             sensor * pole_slope(p[3]) / value};
  }
};

/// In place, of a power of two. Source: J. W. Cooley, J. W. Tukey, Math. Comp. 19 (1965).
void transform(std::span<std::complex<double>> x, std::span<const std::complex<double>> turns) {
  const std::size_t N = x.size();
  for (std::size_t i = 1, j = 0; i < N; ++i) {
    std::size_t bit = N >> 1U;
    for (; (j & bit) != 0; bit >>= 1U) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(x[i], x[j]);
  }
  for (std::size_t half = 1; half < N; half *= 2)
    for (std::size_t first = 0; first < N; first += 2 * half)
      for (std::size_t k = 0; k < half; ++k) {
        const std::complex<double>& w = turns[k * (N / (2 * half))];
        const std::complex<double> b = x[first + half + k];
        const std::complex<double> turned(w.real() * b.real() - w.imag() * b.imag(),
                                          w.real() * b.imag() + w.imag() * b.real());
        const std::complex<double> a = x[first + k];
        x[first + k] = a + turned;
        x[first + half + k] = a - turned;
      }
}

/// x of A x = b, A symmetric and positive, by elimination.
std::array<double, 4> solved(std::array<std::array<double, 4>, 4> A, std::array<double, 4> b) {
  for (int j = 0; j < 4; ++j)
    for (int i = j + 1; i < 4; ++i) {
      const double factor = A[i][j] / A[j][j];
      for (int k = j; k < 4; ++k) A[i][k] -= factor * A[j][k];
      b[i] -= factor * b[j];
    }
  for (int j = 3; j >= 0; --j) {
    for (int k = j + 1; k < 4; ++k) b[j] -= A[j][k] * b[k];
    b[j] /= A[j][j];
  }
  return b;
}

}  // namespace

NoiseSpectrum::NoiseSpectrum(double sample_s, int fewest_blocks) : fewest_blocks_(fewest_blocks) {
  constexpr double kBlockS = 1.0;
  const double samples = sample_s > 0.0 ? kBlockS / sample_s : kMostBlock;
  lay_out(static_cast<int>(std::clamp<double>(samples, kLeastBlock, kMostBlock)));
}

void NoiseSpectrum::lay_out(int size) {
  const int within = std::clamp(size, kLeastBlock, kMostBlock);
  size_ = 1 << static_cast<int>(std::lround(std::log2(within)));
  double power = 0.0;
  for (int k = 0; k < size_; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / size_;
    taper_[k] = 0.5 - 0.5 * std::cos(angle);
    power += taper_[k] * taper_[k];
    if (k < size_ / 2) turns_[k] = {std::cos(angle), -std::sin(angle)};
  }
  for (int k = 0; k < size_; ++k) taper_[k] /= std::sqrt(power);
  // A bin a line at first, then wider in equal ratios, but nowhere so wide that f bends within.
  constexpr double kRatio = 1.1;
  constexpr int kWidest = 10;  // lines
  bin_count_ = 0;
  for (int first = kFirstLine; first < size_ / 2 && bin_count_ < kMostBins; ++bin_count_) {
    const int width = std::clamp(static_cast<int>((kRatio - 1.0) * first), 1, kWidest);
    const int end = std::min(first + width, size_ / 2);
    const double middle = 0.5 * (first + end - 1);
    bins_[bin_count_] = {first, end, std::cos(2.0 * std::numbers::pi * middle / size_), 0.0};
    first = end;
  }
}

bool NoiseSpectrum::add(double sum, int count) {
  bool learnt = false;
  for (int i = 0; i < count; ++i) learnt |= take(sum / count, count > 1);
  return learnt;
}

bool NoiseSpectrum::take(double m, bool spread) {
  spread_[filled_ < size_ / 2 ? 0 : 1] += spread ? 1 : 0;
  block_[filled_++] = m;
  if (filled_ < size_) return false;
  const bool tells = kMostSpread * (spread_[0] + spread_[1]) <= size_;
  if (tells) take_block();
  std::copy(block_.begin() + size_ / 2, block_.begin() + size_, block_.begin());
  filled_ = size_ / 2;
  spread_ = {spread_[1], 0};
  if (!tells || !has_learnt()) return false;
  fit();
  return true;
}

void NoiseSpectrum::take_block() {
  for (int k = 0; k < size_; ++k) lines_[k] = taper_[k] * block_[k];
  const auto size = static_cast<std::size_t>(size_);
  transform(std::span(lines_).first(size), std::span(turns_).first(size / 2));
  ++blocks_;
  // Block n counts as n^2: of twenty blocks the first five, in which the parameters run in, have
  // one part in sixty.
  const double weight = std::max(3.0 / (blocks_ + 2.0), 1.0 / kMostBlocks);
  for (int i = 0; i < bin_count_; ++i) {
    Bin& bin = bins_[i];
    double power = 0.0;
    for (int k = bin.first; k < bin.end; ++k) power += std::norm(lines_[k]);
    bin.density += weight * (power / (bin.end - bin.first) - bin.density);
  }
}

/// Minus twice Whittle's log-likelihood, per block.
double NoiseSpectrum::cost(const Point& p) const {
  double sum = 0.0;
  for (int i = 0; i < bin_count_; ++i) {
    const Density f(p, bins_[i].cosine);
    sum += (bins_[i].end - bins_[i].first) * (std::log(f.value) + bins_[i].density / f.value);
  }
  return sum;
}

/// By Fisher's scoring, with the damping of Levenberg and Marquardt, within the bounds.
NoiseSpectrum::Point NoiseSpectrum::improved(Point p) const {
  double damping = 1e-2;
  double best = cost(p);
  constexpr int kMostSteps = 12;
  for (int step = 0; step < kMostSteps; ++step) {
    std::array<std::array<double, 4>, 4> information{};
    Point score{};
    for (int i = 0; i < bin_count_; ++i) {
      const Density f(p, bins_[i].cosine);
      const double lines = bins_[i].end - bins_[i].first;
      for (int a = 0; a < 4; ++a) {
        score[a] += lines * (bins_[i].density / f.value - 1.0) * f.slope[a];
        for (int b = 0; b < 4; ++b) information[a][b] += lines * f.slope[a] * f.slope[b];
      }
    }
    for (int a = 0; a < 4; ++a) information[a][a] += damping * (information[a][a] + 1.0);
    Point next = solved(information, score);
    for (int a = 0; a < 4; ++a) next[a] = p[a] + std::clamp(next[a], -1.0, 1.0);
    next[1] = std::clamp(next[1], 0.0, kLargestKickPole);
    next[3] = std::clamp(next[3], 0.0, kLargestSensorPole);
    const double there = cost(next);
    if (there < best) {
      const double gained = best - there;
      best = there;
      p = next;
      damping = std::max(0.1 * damping, 1e-6);
      if (gained < 1e-6) break;
    } else {
      damping *= 10.0;
    }
  }
  return p;
}

void NoiseSpectrum::fit() {
  // Sizes to begin with: the sensor's from the upper half, the kick's from the lowest lines.
  double upper = 0.0;
  int lines = 0;
  for (int i = 0; i < bin_count_; ++i) {
    if (bins_[i].cosine > 0.0) continue;
    upper += bins_[i].density / (2.0 * (1.0 - bins_[i].cosine)) * (bins_[i].end - bins_[i].first);
    lines += bins_[i].end - bins_[i].first;
  }
  const double sensor = std::log(std::max(std::sqrt(upper / lines), kLeastSensor));
  const double kick = std::log(std::max(std::sqrt(bins_[0].density), kLeastKick)) - 1.0;
  Point best{};
  double least = INFINITY;
  const auto try_from = [&](const Point& start) {
    const Point end = improved(start);
    if (const double there = cost(end); there < least) {
      least = there;
      best = end;
    }
  };
  if (noise_.kick.sd > 0.0)
    try_from({std::log(noise_.kick.sd), noise_.kick.pole, std::log(noise_.sensor.sd),
              noise_.sensor.pole});
  for (const double kick_pole : {0.3, 0.9})
    for (const double sensor_pole : {0.2, 0.8}) try_from({kick, kick_pole, sensor, sensor_pole});
  noise_ = {{std::max(std::exp(best[0]), kLeastKick), best[1]},
            {std::max(std::exp(best[2]), kLeastSensor), best[3]}};
}

}  // namespace armukf
