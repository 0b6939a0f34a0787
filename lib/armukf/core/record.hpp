#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace armukf {

/// One row of a record. The input u is held from this sample to the next one.
struct Sample {
  double t = 0.0;  // s
  double u = 0.0;  // N.m, motor torque
  double y = 0.0;  // rad/s, motor speed; NaN where the measurement is missing

  template <class Archive>
  void archive(Archive& archive) {
    archive(t, u, y);
  }
};

/// How far (rad) the motor turned, as measured, from sample k - 1 to k; NaN where a speed is
/// missing.
inline double turn_before(const std::vector<Sample>& samples, std::size_t k) {
  return 0.5 * (samples[k - 1].y + samples[k].y) * (samples[k].t - samples[k - 1].t);
}

/// A whole record, in order of time.
struct Record {
  std::string name;  // the file it came from, for messages
  std::vector<Sample> samples;
};

}  // namespace armukf
