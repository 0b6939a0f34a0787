#pragma once

#include "armukf/filter/kalman.hpp"
#include "armukf/filter/noise_spectrum.hpp"

namespace armukf {

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
  /// sample_s: the usual interval (s), 0 as long as nobody knows it.
  explicit NoiseWatch(double sample_s = 0.0) : spectrum_(sample_s) {}

  /// Of a machine whose noise was known before it changed: it is learnt once that is as good.
  static NoiseWatch after_change(double sample_s) {
    constexpr int kFewestBlocks = 8;  // two seconds and a quarter
    NoiseWatch watch;
    watch.spectrum_ = NoiseSpectrum(sample_s, kFewestBlocks);
    return watch;
  }

  /// Takes a used measurement, and what of it the belief took for speed (rad/s), not sensor noise,
  /// before it was seen and since. Returns true where the noises are learnt anew.
  bool see(const Innovation& innovation, double before, double after, const Between& between) {
    const double y = innovation.predicted + innovation.value;
    bool learnt = false;
    if (between.intervals > kMostIntervals) interrupt();
    if (goes_on_) {
      const double expected = before - last_speed_ - between.kicked;
      learnt = spectrum_.add(y - last_y_ - expected, between.intervals);
    }
    last_y_ = y;
    last_speed_ = after;
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
    archive(spectrum_, last_speed_, last_y_, goes_on_);
  }

 private:
  static constexpr int kMostIntervals = 16;  // of which all but the last are missing

  NoiseSpectrum spectrum_;
  double last_speed_ = 0.0;  // rad/s
  double last_y_ = 0.0;      // rad/s
  bool goes_on_ = false;
};

}  // namespace armukf
