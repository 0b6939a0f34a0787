#include "armukf/fit/autoregression.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

/// Forward and backward errors of a prediction from the values between; of order 0 the values.
struct Errors {
  Eigen::VectorXd forward;
  Eigen::VectorXd backward;

  /// The reflection coefficient that makes both smallest one order on.
  double reflection(Eigen::Index order) const {
    const Eigen::Index n = forward.size() - order;
    const auto f = forward.tail(n);
    const auto b = backward.segment(order - 1, n);
    const double power = f.squaredNorm() + b.squaredNorm();
    return power > 0.0 ? 2.0 * f.dot(b) / power : 0.0;
  }

  void advance(Eigen::Index order, double reflection) {
    for (Eigen::Index t = forward.size() - 1; t >= order; --t) {
      const double f = forward[t];
      forward[t] = f - reflection * backward[t - 1];
      backward[t] = backward[t - 1] - reflection * f;
    }
  }
};

/// Coefficients one order on, by the recursion of Levinson.
std::vector<double> extended(const std::vector<double>& a, double reflection) {
  std::vector<double> longer = a;
  for (std::size_t i = 0; i < a.size(); ++i) longer[i] -= reflection * a[a.size() - 1 - i];
  longer.push_back(reflection);
  return longer;
}

}  // namespace

Autoregression::Autoregression(const Eigen::VectorXd& r, int most) {
  const auto n = static_cast<double>(r.size());
  Errors errors{r, r};
  std::vector<double> a;
  double criterion = 0.0;  // n log(power of e / power of r) + 2 order
  double least = 0.0;
  std::vector<double> reflections;
  for (int order = 1; order <= std::min(most, static_cast<int>(r.size()) - 1); ++order) {
    const double reflection = errors.reflection(order);
    errors.advance(order, reflection);
    reflections.push_back(reflection);
    a = extended(a, reflection);
    criterion += n * std::log1p(-reflection * reflection) + 2.0;
    if (!(criterion < least)) continue;
    least = criterion;
    coefficients_ = a;
    reflections_ = reflections;
  }
}

Eigen::VectorXd Autoregression::whitened(const Eigen::VectorXd& r) const {
  Eigen::VectorXd e = r;
  for (Eigen::Index i = 1; i <= std::min<Eigen::Index>(order(), r.size() - 1); ++i)
    e.tail(r.size() - i) -= coefficients_[i - 1] * r.head(r.size() - i);
  return e;
}

JacobianMatrix Autoregression::carried(const JacobianMatrix& X) const {
  JacobianMatrix Z = X;
  for (Eigen::Index t = X.rows() - 1; t >= 0; --t)
    for (Eigen::Index i = 1; i <= std::min<Eigen::Index>(order(), X.rows() - 1 - t); ++i)
      Z.row(t) += coefficients_[i - 1] * Z.row(t + i);
  return Z;
}

/// Of lags 0 ... order - 1, for e of variance 1: Levinson's recursion backwards.
std::vector<double> Autoregression::autocovariances() const {
  double error = 1.0;
  for (const double k : reflections_) error /= 1.0 - k * k;
  std::vector<double> c{error};
  std::vector<double> a;
  for (const double k : reflections_) {
    double next = k * error;
    for (std::size_t i = 0; i < a.size(); ++i) next += a[i] * c[c.size() - 1 - i];
    c.push_back(next);
    error *= 1.0 - k * k;
    a = extended(a, k);
  }
  c.pop_back();
  return c;
}

double Autoregression::freedom(const Eigen::VectorXd& z) const {
  const double power = z.squaredNorm();
  // Twice this is the relative variance of the estimate: of z' e for known coefficients, and by
  // them.
  double uncertainty = z.array().square().matrix().squaredNorm() / (power * power);
  const Eigen::Index n = z.size();
  const Eigen::Index p = std::min<Eigen::Index>(order(), n - 1);
  if (p > 0) {
    Eigen::VectorXd moved = z;  // 1/A of z, forwards: d(z' z)/d a_i = 2 sum_t moved_t z_{t+i}
    for (Eigen::Index t = 0; t < n; ++t)
      for (Eigen::Index i = 1; i <= std::min(p, t); ++i)
        moved[t] += coefficients_[i - 1] * moved[t - i];
    Eigen::VectorXd slope(p);
    for (Eigen::Index i = 1; i <= p; ++i)
      slope[i - 1] = 2.0 * moved.head(n - i).dot(z.tail(n - i)) / power;
    const std::vector<double> c = autocovariances();
    Eigen::MatrixXd information(p, p);
    for (Eigen::Index i = 0; i < p; ++i)
      for (Eigen::Index j = 0; j < p; ++j) information(i, j) = c[std::abs(i - j)];
    uncertainty += 0.5 * slope.dot(symmetric_solution(information, slope)) / static_cast<double>(n);
  }
  return 1.0 / uncertainty;
}

}  // namespace armukf
