#include "armukf/online/wear.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace armukf {

WearBlock::WearBlock(int n) : seen_(n), told_(n), bend_(static_cast<std::size_t>(n)) {}

void WearBlock::clear(double begin) {
  seen_.clear();
  seen_.begin = begin;
  std::ranges::fill(bend_, 0.0);
  moment_ = 0.0;
  level_ = 0;
}

void WearBlock::add(const WearBlock& later) {
  seen_.add(later.seen_);
  for (std::size_t i = 0; i < bend_.size(); ++i) bend_[i] += later.bend_[i];
  moment_ += later.moment_;
  level_ = later.level_ + 1;
  tell();
}

void WearBlock::add(const ChangeSums& sums, std::span<const double> scale,
                    std::span<const double> offset, std::span<const double> bend) {
  seen_.end = sums.end;
  seen_.samples += sums.samples;
  seen_.power += sums.power;
  moment_ += sums.samples * 0.5 * (sums.begin + sums.end);
  for (int i = 0; i < sums.n; ++i) {
    double shift = 0.0;
    for (int j = 0; j < sums.n; ++j) {
      const double g = scale[i] * sums.row(i)[j] * scale[j];
      seen_.row(i)[j] += g;
      shift += g * offset[j];
    }
    seen_.b[i] += scale[i] * sums.b[i] + shift;
    bend_[i] += sums.samples * bend[i] * bend[i];
  }
  tell();
}

/// With S the root of the part of T that is not 0: G - G S (1 + S G S)^-1 S G, and b alike.
void WearBlock::tell() {
  constexpr double kLeastVariance = 1e-18;
  told_ = seen_;
  std::array<int, kMaxParameters> bent;
  std::array<double, kMaxParameters> sd;
  int m = 0;
  for (int i = 0; i < seen_.n && m < kMaxParameters; ++i)
    if (const double v = bend_[i] / std::max(1.0, seen_.samples); v > kLeastVariance) {
      bent[m] = i;
      sd[m++] = std::sqrt(v);
    }
  if (m == 0) return;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters,
                               kMostChangeables + 1>;
  Matrix A = Matrix::Identity(m, m);
  Matrix rows(m, seen_.n + 1);
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < m; ++c) A(r, c) += sd[r] * seen_.row(bent[r])[bent[c]] * sd[c];
    for (int j = 0; j < seen_.n; ++j) rows(r, j) = sd[r] * seen_.row(bent[r])[j];
    rows(r, seen_.n) = sd[r] * seen_.b[bent[r]];
  }
  const Matrix solved = A.llt().solve(rows);
  for (int i = 0; i < seen_.n; ++i) {
    for (int j = 0; j < seen_.n; ++j) told_.row(i)[j] -= rows.col(i).dot(solved.col(j));
    told_.b[i] -= rows.col(i).dot(solved.col(seen_.n));
  }
}

Wear::Wear(int n)
    : steps_(kMostSteps),
      reference_(static_cast<std::size_t>(n)),
      units_(reference_.size()),
      scale_(reference_.size()),
      offset_(reference_.size()),
      bend_(reference_.size()) {
  blocks_.resize(kLevels * kPerLevel + 2, WearBlock(n));
}

void Wear::begin(const std::vector<Changeable>& what, const Condition& reference) {
  count_ = steps_count_ = 0;
  for (std::size_t i = 0; i < what.size(); ++i) {
    reference_[i] = value_of(reference, what[i]);
    units_[i] = what[i].usual;
  }
}

/// What a prediction gets wrong grows with the square of how far the parameter is off.
void Wear::add(const ChangeSums& sums, const std::vector<Changeable>& what, const Condition& frozen,
               const Condition& believed) {
  constexpr double kBend = 3.0;  // of a parameter that is off as far as it may be
  if (!(sums.samples > 0.0)) return;
  for (std::size_t i = 0; i < what.size(); ++i) {
    const double at = value_of(frozen, what[i]);
    scale_[i] = units_[i] / what[i].usual;
    offset_[i] = (at - reference_[i]) / units_[i];
    const double off = value_of(believed, what[i]) - at;
    bend_[i] = kBend * off / units_[i] * off / (what[i].linear * what[i].usual);
  }
  if (count_ == 0 || blocks_[count_ - 1].length() >= kBlockS) {
    merge();
    blocks_[count_++].clear(sums.begin);
  }
  blocks_[count_ - 1].add(sums, scale_, offset_, bend_);
}

void Wear::jump(const std::vector<Changeable>& what, int i, double t, const Condition& from,
                const Condition& to) {
  for (std::size_t k = 0; k < what.size(); ++k)
    reference_[k] += value_of(to, what[k]) - value_of(from, what[k]);
  if (steps_count_ == kMostSteps) {
    std::rotate(steps_.begin(), steps_.begin() + 1, steps_.end());
    --steps_count_;
  }
  steps_[steps_count_++] = {i, t};
}

/// Makes room for a block: where a level has too many, its two oldest become one of the next.
void Wear::merge() {
  for (int level = 0; level < kLevels; ++level) {
    const auto is_here = [&](const WearBlock& b) { return b.level() == level; };
    const auto end = blocks_.begin() + count_;
    if (std::count_if(blocks_.begin(), end, is_here) < kPerLevel) return;
    const int first =
        static_cast<int>(std::find_if(blocks_.begin(), end, is_here) - blocks_.begin());
    if (level + 1 < kLevels) {
      blocks_[first].add(blocks_[first + 1]);
      drop(first + 1);
    } else {
      drop(first);
    }
  }
}

void Wear::drop(int i) {
  std::rotate(blocks_.begin() + i, blocks_.begin() + i + 1, blocks_.begin() + count_);
  --count_;
}

}  // namespace armukf
