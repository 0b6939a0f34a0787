#include "armukf/core/fourier.hpp"

#include <unsupported/Eigen/FFT>

namespace armukf {

std::vector<std::complex<double>> fourier(const std::vector<double>& values) {
  Eigen::FFT<double> transform;
  std::vector<std::complex<double>> lines;
  transform.fwd(lines, values);
  return lines;
}

}  // namespace armukf
