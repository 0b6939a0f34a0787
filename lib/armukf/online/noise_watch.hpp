#pragma once

#include "armukf/filter/kalman.hpp"
#include "armukf/filter/noise_spectrum.hpp"

namespace armukf {

/// A belief's idea of what makes up a measurement, rad/s.
struct MeasuredParts {
  double speed = 0.0;
  double sensor_noise = 0.0;

  template <class Archive>
  void archive(Archive& archive) {
    archive(speed, sensor_noise);
  }
};

/// What lies between two measurements that were used: how many usual intervals, and what the torque
/// noise that is believed in has added to the speed meanwhile (rad/s).
struct Between {
  int intervals = 1;
  double kicked = 0.0;
};

/// Learns the noises from a filter's beliefs: what a sample shows is the last one, the change that
/// the model expects of a motion without noise, and noise.
class NoiseWatch {
 public:
  /// Takes a used measurement, what the belief was of its parts before it was seen, and what it is
  /// since. Returns true where the noises are learnt anew.
  bool see(const Innovation& innovation, const MeasuredParts& before, const MeasuredParts& after,
           const Between& between) {
    const double y = innovation.predicted + innovation.value;
    bool learnt = false;
    if (between.intervals > kMostIntervals) interrupt();
    if (goes_on_) {
      const double expected = before.speed - last_.speed - between.kicked;
      learnt = spectrum_.add(y - last_y_ - expected, between.intervals);
    }
    last_y_ = y;
    last_ = after;
    goes_on_ = true;
    return learnt;
  }

  /// The next sample does not follow the last one.
  void interrupt() {
    spectrum_.interrupt();
    goes_on_ = false;
  }

  const NoisePair& noise() const { return spectrum_.noise(); }

  /// Whether there was enough to learn from.
  bool has_learnt() const { return spectrum_.has_learnt(); }

  template <class Archive>
  void archive(Archive& archive) {
    archive(spectrum_, last_, last_y_, goes_on_);
  }

 private:
  static constexpr int kMostIntervals = 16;  // of which all but the last are missing

  NoiseSpectrum spectrum_;
  MeasuredParts last_;
  double last_y_ = 0.0;  // rad/s
  bool goes_on_ = false;
};

}  // namespace armukf
