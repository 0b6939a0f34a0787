#include "armukf/online/alarm.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace armukf {
namespace {

constexpr double kCarried = 0.7;  // of what is known of drive, sensor and friction, at a new begin
constexpr double kIncomplete = 3.0;  // times the deviation of all that is believed
constexpr double kEarly = 2.0;       // times its variance: an early belief is too sure

/// At most so large, and so on the stack.
using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;

}  // namespace

Alarm::Alarm(int n)
    : ring_(n),
      test_(n),
      spread_(static_cast<std::size_t>(n), 1.0),
      spread_sum_(static_cast<std::size_t>(n), 0.0) {}

void Alarm::begin(const std::vector<Changeable>& what, const SquareMatrix& covariance,
                  std::span<const double> off, double since) {
  const int m = covariance.size();
  bends_of_looks_.fill(0.0);
  looks_ = 0;
  if (since > -kInfinite) {
    test_.carry_over(m, kCarried, since, ring_);
  } else {
    ring_.restart();
  }
  const double doubt = complete_ ? 1.0 : kIncomplete;
  if (!complete_) first_.reset();
  test_.believe(what, doubt);
  SmallMatrix relative(m, m);
  SmallVector offset = SmallVector::Zero(m);
  for (int i = 0; i < m; ++i) {
    if (!off.empty()) offset[i] = off[i] / what[i].usual;
    for (int j = 0; j < m; ++j)
      relative(i, j) = kEarly * doubt * doubt * covariance(i, j) / (what[i].usual * what[j].usual);
  }
  const SmallMatrix inverse = relative.ldlt().solve(SmallMatrix::Identity(m, m));
  const SmallVector pull = inverse * offset;
  for (int i = 0; i < m; ++i) {
    ring_.past().b[i] = pull[i];
    for (int j = 0; j < m; ++j) ring_.past().row(i)[j] = inverse(i, j);
  }
}

bool Alarm::close(double memory_s) {
  if (!ring_.close()) return false;
  ring_.take_left(1.0 - (ring_.left().end - ring_.left().begin) / memory_s);
  return true;
}

bool Alarm::look(double memory_s, bool learns) {
  const bool has_left = close(memory_s);
  if (has_left && learns) learn_spread();
  if (learns) earliest_ = earliest();
  test_.look(ring_, earliest_, memory_s);
  return has_left;
}

double Alarm::earliest() const {
  if (complete_) return least_earliest_;
  const double first = first_.value_or(0.0);
  return std::max(first + claim_s_, 0.5 * (first + last().end));
}

void Alarm::learn_spread() {
  constexpr double kPrior = ChangeTest::kPriorStretches;
  constexpr double kMost = 25.0;  // of the spread: an outlier counts no more
  const ChangeSums& left = ring_.left();
  spread_weight_ += 1.0;
  for (int i = 0; i < left.n; ++i) {
    if (const std::optional<double> square = test_.square_of_score(i, left))
      spread_sum_[i] += std::min(*square, kMost * spread_[i]);
    spread_[i] = std::max(1.0, (kPrior + spread_sum_[i]) / (kPrior + spread_weight_));
  }
}

void Alarm::find_bend(const Model& model, const std::vector<Changeable>& what) {
  if (!complete_) return;
  double now = 1.0;
  for (std::size_t i = 0; i < what.size(); ++i) {
    if (!what[i].is_parameter() || model.parameters[what[i].parameter].known) continue;
    const double sd = test_.offset_sd(static_cast<int>(i));
    const double off = test_.offset()[i];
    const double square = sd * sd + off * off;
    const double shown = std::min(1.0, test_.recent_information()[i] * square);
    now = std::max(now, 1.0 + shown * square / (what[i].linear * what[i].linear));
  }
  // What has just changed bends nothing: it counts what was some looks ago, or at the first one.
  double& oldest = bends_of_looks_[looks_ % bends_of_looks_.size()];
  const double then = oldest;
  oldest = now;
  bend_ = then > 0.0 ? then : bends_of_looks_.front();
  ++looks_;
}

int Alarm::likeliest() const {
  int best = 0;
  for (int i = 0; i < static_cast<int>(spread_.size()); ++i)
    if (likelihood(i) > likelihood(best)) best = i;
  return best;
}

double Alarm::likelihood_of_drift() const {
  double most = 0.0;
  for (int i = 0; i < static_cast<int>(spread_.size()); ++i)
    most = std::max(most, test_.drift_statistic(i) / (spread(i) * bend_));
  return most;
}

double Alarm::rest_of_power() const {
  const ChangeSums& sums = last();
  const auto& theta = test_.offset();
  double rest = sums.power;
  for (int i = 0; i < sums.n; ++i) {
    double explained = -2.0 * sums.b[i];
    for (int j = 0; j < sums.n; ++j) explained += sums.row(i)[j] * theta[j];
    rest += theta[i] * explained;
  }
  return std::max(0.0, rest) / sums.samples;
}

double Alarm::power_before(double t) const {
  double power = ring_.past().power;
  double samples = ring_.past().samples;
  for (int i = 0; i < ring_.size() && ring_.step(i).end <= t; ++i) {
    power += ring_.step(i).power;
    samples += ring_.step(i).samples;
  }
  return samples > 0.0 ? power / samples : 1.0;
}

}  // namespace armukf
