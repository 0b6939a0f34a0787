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
