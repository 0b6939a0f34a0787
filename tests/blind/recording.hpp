#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "changes.hpp"
#include "reference.hpp"
#include "world.hpp"

namespace blind {

struct Sample {
  double u;  // N.m, commanded
  double y;  // rad/s, measured
};

struct Record {
  Motion motion;
  State start;  // at the first sample
  std::vector<Sample> samples;
};

enum class Use : std::uint8_t { kEstimation, kValidation, kTest };

/// The arm under speed control, some seconds after it started from rest. Motion, phases and noise
/// are those of the world's seed and of the use; `noise_factor` is on both noises; the speed to
/// follow repeats every `period` (s), by default once. Throws std::runtime_error if the loop is
/// unstable or hunts from limit to limit.
Record recorded(const World& world, const Effects& effects, Use use, double duration,
                double noise_factor, const std::vector<Change>& changes = {}, double period = 0.0);

void write_csv(const std::string& path, const std::vector<Sample>& samples);

}  // namespace blind
