#pragma once

namespace armukf {

/// How an adaptive filter follows the size of sensor and state noise.
struct Adaptation {
  double time_s = 0.3;     // s, over which the innovations are watched
  double settle_s = 0.03;  // s, in which the model error of the beginning, see Noise, decays
  double least = 0.01;     // of the factors on the standard deviations of the noise
  double most = 100.0;
};

}  // namespace armukf
