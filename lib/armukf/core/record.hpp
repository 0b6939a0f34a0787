#pragma once

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

/// A whole record, in order of time.
struct Record {
  std::string name;  // the file it came from, for messages
  std::vector<Sample> samples;
};

}  // namespace armukf
