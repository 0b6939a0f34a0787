#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// Transfer function from motor torque (N.m) to motor speed (rad/s) of the arm about rest, without
/// friction, by its modes: G(j w) = sum_i r_i / (j w - lambda_i).
class FrequencyResponse {
 public:
  explicit FrequencyResponse(const Model& model);

  /// (rad/s)/(N.m) at the angular frequency w (rad/s) > 0.
  std::complex<double> operator()(double w) const;

 private:
  Eigen::Matrix<std::complex<double>, kArmStates, 1> poles_;
  Eigen::Matrix<std::complex<double>, kArmStates, 1> residues_;
};

/// Frequencies (rad/s) at which three undamped masses on a line hold the first one still (zeros)
/// and swing by themselves (poles); zero[0] < pole[0] < zero[1] < pole[1].
struct Resonances {
  std::array<double, 2> zero;
  std::array<double, 2> pole;
};

/// Sets a_m, a_g, k_g1 and k_a to what has these resonances with the model's J: the continued
/// fraction of torque over speed, whose terms alternate between masses and springs (Cauer's first
/// form; W. Cauer, "Die Verwirklichung von Wechselstromwiderstaenden vorgeschriebener
/// Frequenzabhaengigkeit", Archiv fuer Elektrotechnik 17, 1926).
void set_resonances(Model& model, const Resonances& resonances);

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
