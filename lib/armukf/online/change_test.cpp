#include "armukf/online/change_test.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace armukf {
namespace {

/// Less than a thousandth of a doubt's: rounding, or nothing that could be seen.
constexpr double kLeastInformation = 1e-3;

/// Lower root of a symmetric matrix, in place; false where it is not positive.
bool factor(ChangeSums& a) {
  for (int j = 0; j < a.n; ++j) {
    for (int i = j; i < a.n; ++i) {
      double sum = a.row(i)[j];
      for (int k = 0; k < j; ++k) sum -= a.row(i)[k] * a.row(j)[k];
      if (i == j && !(sum > 0.0)) return false;
      a.row(i)[j] = i == j ? std::sqrt(sum) : sum / a.row(j)[j];
    }
  }
  return true;
}

}  // namespace

ChangeTest::ChangeTest(int n)
    : n_(n),
      findings_(n),
      all_(n),
      after_(n),
      work_(all_.G.size()),
      theta_(all_.b.size()),
      precision_(theta_.size()),
      recent_(theta_.size()),
      score_(theta_.size()),
      information_(theta_.size()),
      drift_(n),
      drift_statistics_(theta_.size()) {}

void ChangeTest::believe(const std::vector<Changeable>& what, double times) {
  for (int i = 0; i < n_; ++i) {
    const double sd = times * what[i].doubt;
    precision_[i] = 1.0 / (sd * sd);
  }
}

void ChangeTest::gather(const ChangeRing& ring, double until) {
  all_.clear();
  all_.add(ring.past());
  for (int i = 0; i < ring.size() && ring.step(i).end <= until; ++i) all_.add(ring.step(i));
  for (int i = 0; i < n_; ++i) all_.row(i)[i] += precision_[i];
  if (factor(all_)) find_offset(std::span(theta_).first(n_));
}

/// The root's first rows are the root of that part.
void ChangeTest::find_offset(std::span<double> offset) const {
  const int n = static_cast<int>(offset.size());
  for (int i = 0; i < n; ++i) {
    double sum = all_.b[i];
    for (int k = 0; k < i; ++k) sum -= all_.row(i)[k] * offset[k];
    offset[i] = sum / all_.row(i)[i];
  }
  for (int i = n - 1; i >= 0; --i) {
    double sum = offset[i];
    for (int k = i + 1; k < n; ++k) sum -= all_.row(k)[i] * offset[k];
    offset[i] = sum / all_.row(i)[i];
  }
}

void ChangeTest::solve_rows(const ChangeSums& sums) {
  const int stride = sums.stride;
  work_ = sums.G;
  for (int i = 0; i < n_; ++i) {
    double* to = work_.data() + static_cast<std::ptrdiff_t>(i) * stride;
    const double* root = all_.row(i);
    for (int k = 0; k < i; ++k) {
      const double* from = work_.data() + static_cast<std::ptrdiff_t>(k) * stride;
      const double factor = root[k];
      for (int j = 0; j < stride; ++j) to[j] -= factor * from[j];
    }
    const double inverse = 1.0 / root[i];
    for (int j = 0; j < stride; ++j) to[j] *= inverse;
  }
}

/// The information is that of all else being known, until now.
void ChangeTest::score(const ChangeSums& sums) {
  solve_rows(sums);
  score_ = sums.b;
  for (int k = 0; k < n_; ++k) {
    const double* g = sums.row(k);
    const double* w = work_.data() + static_cast<std::ptrdiff_t>(k) * sums.stride;
    const double offset = theta_[k];
    for (int j = 0; j < sums.stride; ++j) {
      score_[j] -= g[j] * offset;
      information_[j] -= w[j] * w[j];
    }
  }
}

/// What is past has faded, and is as old as it still counts for. Without a prior of the rate, a
/// change soon after the begin would be a drift as well: of a few seconds both are the same.
void ChangeTest::look_at_drifts(const ChangeRing& ring, double drift_s) {
  const double begin = ring.step(0).begin;
  const double length = ring.step(ring.size() - 1).end - begin;
  double samples = 0.0;
  for (int s = 0; s < ring.size(); ++s) samples += ring.step(s).samples;
  drift_.clear();
  std::ranges::fill(information_, 0.0);
  const auto add = [&](const ChangeSums& sums, double weight) {
    drift_.add(sums, weight);
    for (int i = 0; i < n_; ++i) information_[i] += weight * weight * sums.row(i)[i];
  };
  add(ring.past(), -ring.past().samples / samples);
  for (int s = 0; s < ring.size(); ++s)
    add(ring.step(s), (0.5 * (ring.step(s).begin + ring.step(s).end) - begin) / length);
  score(drift_);
  const double prior = drift_s * drift_s / (length * length);  // information
  for (int i = 0; i < n_; ++i)
    drift_statistics_[i] = information_[i] > kLeastInformation
                               ? score_[i] * score_[i] / (information_[i] + prior)
                               : 0.0;
}

void ChangeTest::look(const ChangeRing& ring, double earliest, double drift_s) {
  gather(ring);
  look_at_drifts(ring, drift_s);
  std::ranges::fill(findings_, Finding{});
  after_.clear();
  for (int s = ring.size() - 1; s >= 0; --s) {
    after_.add(ring.step(s));
    for (int j = 0; j < after_.stride; ++j) information_[j] = j < n_ ? after_.row(j)[j] : 0.0;
    score(after_);
    for (int i = 0; i < n_; ++i) {
      const double information = information_[i];
      if (after_.end - after_.begin < kRecentS) recent_[i] = information;
      if (!(information > kLeastInformation) || ring.step(s).begin < earliest) continue;
      const double statistic = score_[i] * score_[i] / information;
      if (statistic > findings_[i].statistic)
        findings_[i] = {statistic, ring.step(s).begin, score_[i] / information,
                        1.0 / std::sqrt(information), information / after_.row(i)[i]};
    }
  }
}

std::optional<double> ChangeTest::square_of_score(int i, const ChangeSums& stretch) const {
  double score = stretch.b[i];
  for (int k = 0; k < n_; ++k) score -= stretch.row(i)[k] * theta_[k];
  const double information = stretch.row(i)[i];
  if (!(information > kLeastInformation)) return std::nullopt;
  return score * score / information;
}

double ChangeTest::spread_before(double onset, int i, const ChangeRing& ring) {
  constexpr double kStretchS = 0.4;
  gather(ring, onset);
  double sum = kPriorStretches;
  double count = kPriorStretches;
  after_.clear();
  for (int s = 0; s < ring.size() && ring.step(s).end <= onset; ++s) {
    after_.add(ring.step(s));
    if (after_.end - after_.begin < kStretchS) continue;
    if (const std::optional<double> square = square_of_score(i, after_)) {
      sum += *square;
      count += 1.0;
    }
    after_.clear();
  }
  gather(ring);
  return std::max(1.0, sum / count);
}

/// Schur's complement of the information is the product of the root's last rows.
void ChangeTest::carry_over(int first, double weight, double until, ChangeRing& ring) {
  gather(ring, until);
  ring.restart();
  ChangeSums& to = ring.past();
  for (int i = first; i < n_; ++i) {
    to.b[i] = precision_[i] * theta_[i];
    for (int j = first; j < n_; ++j) {
      double sum = i == j ? -precision_[i] : 0.0;
      for (int k = first; k <= std::min(i, j); ++k) sum += all_.row(i)[k] * all_.row(j)[k];
      to.row(i)[j] += weight * sum;
      to.b[i] += weight * sum * theta_[j];
    }
  }
}

double ChangeTest::offset_sd(int i) const {
  // Column i of L^-1, squared: the i-th diagonal of A^-1.
  double sum = 0.0;
  std::array<double, kMostChangeables> column{};
  for (int r = i; r < n_; ++r) {
    double v = r == i ? 1.0 : 0.0;
    for (int k = i; k < r; ++k) v -= all_.row(r)[k] * column[k];
    column[r] = v / all_.row(r)[r];
    sum += column[r] * column[r];
  }
  return std::sqrt(sum);
}

}  // namespace armukf
