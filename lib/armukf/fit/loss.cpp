#include "armukf/fit/loss.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace armukf {

void soften(double scale, Eigen::VectorXd& r, JacobianMatrix& J) {
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    const double size = std::abs(r[i]);
    if (!(size > scale)) continue;
    const double softened = std::sqrt(scale * (2.0 * size - scale));
    r[i] = std::copysign(softened, r[i]);
    J.row(i) *= scale / softened;
  }
}

HuberScore huber_score(double scale, const Eigen::VectorXd& r, const JacobianMatrix& J,
                       int measured) {
  HuberScore score{r, J, 1.0};
  int outer = 0;
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    if (!(std::abs(r[i]) > scale)) continue;
    score.psi[i] = std::copysign(scale, r[i]);
    score.inner.row(i).setZero();
    ++outer;
  }
  score.share = 1.0 - static_cast<double>(outer) / std::max(1, measured);
  return score;
}

double bulk_deviation(const Eigen::VectorXd& r) {
  constexpr double kNormal = 1.4826;  // sd of a normal variable over its median magnitude
  std::vector<double> sizes;
  for (const double x : r)
    if (x != 0.0) sizes.push_back(std::abs(x));
  if (sizes.empty()) return 0.0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  return kNormal * *middle;
}

}  // namespace armukf
