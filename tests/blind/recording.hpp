#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "arm.hpp"

namespace blind {

struct Sample {
  double u;  // N.m, commanded
  double y;  // rad/s, measured
};

/// What both records of an arm share.
struct Setting {
  Effects effects;
  std::uint64_t arm = 0;
  std::uint64_t seed = 1;   // of phases and noise
  double noise = 0.1;       // rad/s, sd of the measured speed's noise
  double noise_pole = 0.0;  // of that noise, an AR(1) process; 0 is white
  int controller = 0;       // of kControllers
  double duration = 10.0;   // s
};

constexpr double kSampleTime = 5e-4;  // s
constexpr int kControllers = 3;

/// The arm under speed control along a multisine of 1 to 40 Hz on a low-passed square wave, of
/// which one period has passed from rest when the record begins. Phases and noise are those of the
/// seed and `stream`. Throws std::runtime_error if the loop is unstable.
std::vector<Sample> recorded(const Setting& setting, std::uint64_t stream);

void write_csv(const std::string& path, const std::vector<Sample>& samples);

}  // namespace blind
