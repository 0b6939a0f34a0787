#pragma once

#include <array>
#include <complex>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// Transfer function from motor torque (N.m) to motor speed (rad/s) of the arm about rest, without
/// friction, as a ratio of polynomials in s = j w.
class FrequencyResponse {
 public:
  explicit FrequencyResponse(const Model& model);

  /// (rad/s)/(N.m) at the angular frequency w (rad/s) > 0.
  std::complex<double> operator()(double w) const;

 private:
  std::array<double, kArmStates> numerator_;  // coefficients by powers of s
  std::array<double, kArmStates + 1> denominator_;
};

/// What one frequency of a record holds: torque and speed there, friction taken off the torque.
struct Line {
  double w;                     // rad/s
  std::complex<double> torque;  // N.m
  std::complex<double> speed;   // rad/s, both under a Hann window, to the same arbitrary factor
};

/// The lines of a record over the band that is excited, ascending. The
/// friction is that of the model's parameters. Missing speeds are bridged.
std::vector<Line> excited_lines(const Model& model, const std::vector<Sample>& samples);

}  // namespace armukf
