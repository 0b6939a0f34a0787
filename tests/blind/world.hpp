#pragma once

#include <cstdint>

#include "arm.hpp"

namespace blind {

/// Noise x[n + 1] = pole x[n] + e[n] of standard deviation sd, a value per sample.
struct ColouredNoise {
  double sd;
  double pole;
};

/// Control of the speed. The measured speed passes a low-pass first; the integral, if there is one,
/// rests at the limit of the torque.
struct Controller {
  double proportional;   // N.m.s/rad
  double integral_time;  // s; infinity: none
  double filter_time;    // s
};

enum class Motion : std::uint8_t {
  kSquareAndMultisine,  // as in the published study
  kRandomPhase,         // more of slow than of fast, phases drawn
  kMoves,               // trapezoids with reversals and rests, a little multisine on top
};

/// What the seed decides: the arm, its noises, who controls it, and along what it moves.
struct World {
  std::uint64_t seed;
  ArmValues arm;
  ColouredNoise sensor;  // rad/s
  ColouredNoise torque;  // N.m, at the motor and not in u
  Controller controller;
  Motion motion;             // of estimation and validation record
  Motion test_motion;        // of the third
  std::uint64_t noise_seed;  // usually the seed
};

World drawn_world(std::uint64_t seed);

}  // namespace blind
