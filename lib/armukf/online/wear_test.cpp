#include "armukf/online/wear_test.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace armukf {
namespace {

constexpr int kMostFound = 6;
/// Constants, jumps and ramps. At most so many, and so on the stack: a watch that runs fits as
/// well.
constexpr int kMost = kMostChangeables + Wear::kMostSteps + kMostFound;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;

constexpr double kShortestS = 30.0;  // s, of a ramp: what is faster is for the alarm
constexpr double kLeastToTell = 1e-3;
constexpr double kPriorBlocks = 4.0;  // that the spread of the alarm counts for

/// How one change moves beside the constant part: a ramp that is 1 at the end, or a step to 1.
struct Shape {
  int i = 0;
  double from = 0.0;   // s
  double slope = 0.0;  // 1/s; 0: a step

  double at(double t) const {
    if (slope == 0.0) return t > from ? 1.0 : 0.0;
    return std::max(0.0, slope * (t - from));
  }
};

/// A shape that explains something.
struct Candidate {
  Shape shape;
  double likelihood = 0.0;  // twice the log of its ratio
  double evidence = 0.0;    // the same with the name's prior
};

/// The regression of constant parts and some shapes.
class Regression {
 public:
  Regression(const Wear& wear, std::span<const WearPrior> priors) : wear_(&wear), priors_(priors) {
    for (int k = 0; k < wear.steps(); ++k) shapes_[count_++] = {wear.step(k).i, wear.step(k).t};
    solve();
  }

  void add(const Shape& shape) {
    shapes_[count_++] = shape;
    solve();
  }

  /// The same without its k-th shape.
  Regression without(int k) const {
    Regression other(*this);
    std::copy(shapes_.begin() + k + 1, shapes_.begin() + count_, other.shapes_.begin() + k);
    --other.count_;
    other.solve();
    return other;
  }

  const Wear& wear() const { return *wear_; }
  std::span<const Shape> shapes() const { return std::span(shapes_).first(count_); }
  double constant(int i) const { return theta_[i]; }
  double amount(int k) const { return theta_[constants() + k]; }
  double variance(int k) const {
    const int m = constants() + k;
    return root_.solve(Vector::Unit(theta_.size(), m))[m];
  }

  double log_prior(int i) const { return priors_[i].log_prior; }

  /// Variance of the i-th change's block scores over that of white innovations, if what is left of
  /// their squares were less by `explained`.
  double spread(int i, double explained = 0.0) const {
    const double left = std::max(0.0, squares_[i] - explained);
    return std::max(
        {1.0, priors_[i].spread, (kPriorBlocks + left) / (kPriorBlocks + wear_->size())});
  }

  /// The amount of every change along a shape, and its information, all else being free.
  void look(Shape shape, Vector& amount, Vector& information) const {
    const int n = constants();
    Matrix M = Matrix::Zero(theta_.size(), n);
    Vector score = Vector::Zero(n);
    information = Vector::Zero(n);
    for (int k = 0; k < wear_->size(); ++k) {
      const WearBlock& block = wear_->block(k);
      const double w = shape.at(block.at());
      if (w == 0.0) continue;
      for (int i = 0; i < n; ++i) {
        const double* g = block.sums().row(i);
        score[i] += w * block.sums().b[i];
        information[i] += w * w * g[i];
        for (int j = 0; j < n; ++j) M(j, i) += w * g[j];
      }
      for (std::size_t s = 0; s < count_; ++s) {
        const double other = shapes_[s].at(block.at());
        for (int i = 0; i < n; ++i)
          M(n + static_cast<int>(s), i) += w * other * block.sums().row(shapes_[s].i)[i];
      }
    }
    const Matrix AM = root_.solve(M);
    for (int i = 0; i < n; ++i) information[i] -= M.col(i).dot(AM.col(i));
    score -= M.transpose() * theta_;
    amount = score.cwiseQuotient(information.cwiseMax(kLeastToTell));
  }

 private:
  int constants() const { return static_cast<int>(priors_.size()); }

  void solve() {
    const int n = constants();
    const int m = n + static_cast<int>(count_);
    Matrix A = Matrix::Zero(m, m);
    Vector b = Vector::Zero(m);
    for (int i = 0; i < n; ++i) A(i, i) = 1.0 / (priors_[i].sd * priors_[i].sd);
    for (int s = n; s < m; ++s) A(s, s) = kLeastToTell;
    Vector w(m);
    for (int k = 0; k < wear_->size(); ++k) {
      const WearBlock& block = wear_->block(k);
      for (int r = 0; r < m; ++r) {
        w[r] = factor(r, block);
        b[r] += w[r] * block.sums().b[index(r)];
        for (int c = 0; c <= r; ++c) A(r, c) += w[r] * w[c] * block.sums().row(index(r))[index(c)];
      }
    }
    root_.compute(A);
    theta_ = root_.solve(b);
    find_squares();
  }

  int index(int r) const { return r < constants() ? r : shapes_[r - constants()].i; }
  double factor(int r, const WearBlock& block) const {
    return r < constants() ? 1.0 : shapes_[r - constants()].at(block.at());
  }

  /// What the fit leaves of the blocks' scores.
  void find_squares() {
    const int n = constants();
    squares_ = Vector::Zero(n);
    for (int k = 0; k < wear_->size(); ++k) {
      const WearBlock& block = wear_->block(k);
      Vector c = theta_.head(n);
      for (std::size_t s = 0; s < count_; ++s)
        c[shapes_[s].i] += amount(static_cast<int>(s)) * shapes_[s].at(block.at());
      for (int i = 0; i < n; ++i) {
        const double* g = block.sums().row(i);
        double score = block.sums().b[i];
        for (int j = 0; j < n; ++j) score -= g[j] * c[j];
        if (g[i] > kLeastToTell) squares_[i] += score * score / g[i];
      }
    }
  }

  const Wear* wear_;
  std::span<const WearPrior> priors_;
  std::array<Shape, Wear::kMostSteps + kMostFound> shapes_{};
  std::size_t count_ = 0;  // of them
  Eigen::LLT<Matrix> root_;
  Vector theta_;
  Vector squares_;
};

double end_of(const Wear& wear) { return wear.block(wear.size() - 1).end(); }

Shape ramp(double from, double end) { return {0, from, 1.0 / (end - from)}; }

/// The likeliest ramp or step.
Candidate best_of(const Regression& fit) {
  const Wear& wear = fit.wear();
  Candidate best;
  Vector amount;
  Vector information;
  const auto compare = [&](Shape shape) {
    fit.look(shape, amount, information);
    for (int i = 0; i < amount.size(); ++i) {
      if (!(information[i] > kLeastToTell)) continue;
      const double statistic = amount[i] * amount[i] * information[i];
      const double likelihood = statistic / fit.spread(i, statistic);
      const double evidence = likelihood + 2.0 * fit.log_prior(i);
      shape.i = i;
      if (evidence > best.evidence) best = {shape, likelihood, evidence};
    }
  };
  const double end = end_of(wear);
  for (int k = 0; k < wear.size(); ++k) {
    const double from = wear.block(k).begin();
    if (end - from >= kShortestS) compare(ramp(from, end));
    if (k > 0) compare({0, from, 0.0});
  }
  return best;
}

/// What a shape takes from the sum of squares.
double square_of_ramp(const Regression& fit, int i, const Shape& shape) {
  Vector amount;
  Vector information;
  fit.look(shape, amount, information);
  return amount[i] * amount[i] * information[i];
}

/// A ramp's rate, whenever it has begun: the mean over all starts, each as likely as its ramp makes
/// the samples, and with the spread of the starts' rates (J. Hoeting et al., "Bayesian model
/// averaging", Stat. Sci. 14, 1999). The likeliest start alone would be too sure of its rate.
struct MeanRate {
  double rate = 0.0;      // 1/s
  double variance = 0.0;  // of it
};

/// What wears has done so from the first sample on as likely as not; else from any time.
double prior_of_start(const Wear& wear, int block) {
  constexpr double kFromBegin = 0.5;
  if (block == 0) return kFromBegin;
  return (1.0 - kFromBegin) * wear.block(block).length() / (end_of(wear) - wear.block(0).end());
}

/// Of the k-th shape of a fit, the others being what they are.
MeanRate rate_over_starts(const Regression& fit, int k) {
  const Wear& wear = fit.wear();
  const int i = fit.shapes()[k].i;
  const Regression rest = fit.without(k);
  const double spread = fit.spread(i);
  const double end = end_of(wear);
  const double most = square_of_ramp(rest, i, fit.shapes()[k]) / spread;
  double weights = 0.0;
  MeanRate mean;
  Vector amount;
  Vector information;
  for (int b = 0; b < wear.size() && end - wear.block(b).begin() >= kShortestS; ++b) {
    const Shape shape = ramp(wear.block(b).begin(), end);
    rest.look(shape, amount, information);
    if (!(information[i] > kLeastToTell)) continue;
    const double likelihood = amount[i] * amount[i] * information[i] / spread;
    const double weight = prior_of_start(wear, b) * std::exp(0.5 * (likelihood - most));
    const double rate = amount[i] * shape.slope;
    weights += weight;
    const double off = rate - mean.rate;
    mean.rate += weight / weights * off;
    mean.variance +=
        weight * (off * (rate - mean.rate) + spread / information[i] * shape.slope * shape.slope);
  }
  mean.variance /= weights;
  return mean;
}

}  // namespace

std::vector<FoundWear> found_wear(const Wear& wear, std::span<const WearPrior> priors,
                                  double threshold) {
  std::vector<FoundWear> found(priors.size());
  if (!find_wear(wear, priors, threshold, found)) found.clear();
  return found;
}

bool find_wear(const Wear& wear, std::span<const WearPrior> priors, double threshold,
               std::span<FoundWear> found) {
  if (wear.size() < 2 || end_of(wear) - wear.block(0).begin() < kShortestS) return false;
  std::ranges::fill(found, FoundWear{});
  Regression fit(wear, priors);
  for (int k = 0; k < kMostFound; ++k) {
    const Candidate best = best_of(fit);
    if (!(best.likelihood > threshold)) break;
    fit.add(best.shape);
  }
  // Of what does not drift: what its rate over all could be.
  const double begin = wear.block(0).begin();
  const double length = end_of(wear) - begin;
  Vector amount;
  Vector information;
  fit.look(ramp(begin, end_of(wear)), amount, information);
  for (int i = 0; i < static_cast<int>(found.size()); ++i) {
    found[i].offset = fit.constant(i);
    found[i].since = begin;
    if (!(information[i] > kLeastToTell)) continue;
    found[i].rate = amount[i] / length;
    found[i].sd = std::sqrt(fit.spread(i) / information[i]) / length;
  }
  for (std::size_t k = 0; k < fit.shapes().size(); ++k) {
    const Shape& shape = fit.shapes()[k];
    FoundWear& wears = found[shape.i];
    const int at = static_cast<int>(k);
    wears.offset += fit.amount(at);
    if (shape.slope == 0.0) continue;
    if (!std::exchange(wears.drifts, true)) wears.rate = wears.sd = 0.0;
    const MeanRate mean = rate_over_starts(fit, at);
    wears.rate += mean.rate;
    wears.sd = std::hypot(wears.sd, std::sqrt(mean.variance));
    wears.since = std::max(wears.since, shape.from);
  }
  // Beside the others' a rate may no more be beyond chance.
  for (FoundWear& wears : found)
    wears.drifts = wears.drifts && wears.rate * wears.rate > threshold * wears.sd * wears.sd;
  return true;
}

}  // namespace armukf
