#pragma once

#include <Eigen/Core>
#include <vector>

namespace armukf {

/// What a least-squares fit takes from the noise at each frequency: of white noise that columns Q,
/// orthonormal, are fitted to, the residual lacks the share h(w) = sum_j |Q_j(w)|^2 / n of the
/// power at w. Slow columns leave little of slow noise, and the residual of a short record looks
/// quicker than the noise was.
class Leverage {
 public:
  /// Of orthonormal columns.
  explicit Leverage(const Eigen::MatrixXd& Q);

  /// The power of z over that of what the fit leaves of it, on the average over the frequencies of
  /// z; `further` columns, orthonormal to each other and to Q, are fitted as well. At least 1.
  double loss(const Eigen::VectorXd& z, const Eigen::MatrixXd& further) const;

 private:
  void add(const Eigen::MatrixXd& Q, std::vector<double>& power) const;

  std::size_t length_;         // of the transforms
  std::vector<double> power_;  // sum_j |Q_j|^2 at each line
};

}  // namespace armukf
