#pragma once

#include <algorithm>
#include <array>
#include <complex>

namespace armukf {

/// Stationary noise, a value per sample: x_{k+1} = pole x_k + e_k, of standard deviation sd.
struct ColouredNoise {
  double sd = 0.0;
  double pole = 0.0;

  /// Variance per sample of the white noise that has the same density at low frequencies.
  double long_run_variance() const { return sd * sd * (1.0 + pole) / (1.0 - pole); }
  /// Variance of e.
  double driving_variance() const { return sd * sd * (1.0 - pole * pole); }

  template <class Archive>
  void archive(Archive& archive) {
    archive(sd, pole);
  }
};

/// Noises of a moving mass whose speed is measured, per sample: `kick` is what a torque that nobody
/// knows adds to the speed from one sample to the next, `sensor` what the sensor adds to it.
struct NoisePair {
  ColouredNoise kick;    // rad/s
  ColouredNoise sensor;  // rad/s

  template <class Archive>
  void archive(Archive& archive) {
    archive(kick, sensor);
  }
};

/// Learns both from what a model leaves of the measured change of speed,
///     m_k = y_k - y_{k-1} - (change that the model expects of a motion without noise)
///         = kick_{k-1} + sensor_k - sensor_{k-1},
/// whose spectrum at w radians a sample is
///     f(w) = S_kick(w) + |1 - e^{-iw}|^2 S_sensor(w),  S(w) = sd^2 (1 - p^2) / |1 - p e^{-iw}|^2.
/// The spectrum is averaged over overlapping blocks (P. Welch, IEEE Trans. Audio and
/// Electroacoustics 15, 1967), later ones counting more, since what is wrong with unsettled
/// parameters is in the early ones; sizes and poles maximise the likelihood of P. Whittle, "The
/// analysis of multiple stationary time series", JRSS B 15 (1953). Memory is constant.
class NoiseSpectrum {
 public:
  /// sample_s: the usual interval (s; 0: that of the published record), of which a block holds a
  /// second or, of fast ones, kMostBlock. fewest_blocks: beyond so many it is learnt; from the
  /// spectrum of one block four numbers can hardly be read.
  explicit NoiseSpectrum(double sample_s = 0.0, int fewest_blocks = 1);

  /// Takes the next m (rad/s); or the sum of some in a row, of measurements that are missing, which
  /// is spread evenly. Returns true where a block is full and the noises are learnt anew; a block
  /// of which too much was spread tells nothing.
  bool add(double sum, int count = 1);

  /// A gap: m's before it and after it do not belong into one block.
  void interrupt() {
    filled_ = 0;
    spread_ = {};
  }

  bool has_learnt() const { return blocks_ > fewest_blocks_; }
  const NoisePair& noise() const { return noise_; }

  template <class Archive>
  void archive(Archive& archive) {
    int size = size_;
    archive(size);
    if (size != size_) lay_out(size);
    archive(block_, filled_, spread_, blocks_, fewest_blocks_, noise_);
    for (Bin& bin : bins_) archive(bin.density);
    filled_ = std::clamp(filled_, 0, size_ - 1);  // it is an index, whoever wrote the archive
  }

 private:
  static constexpr int kLeastBlock = 128;  // samples
  static constexpr int kMostBlock = 1024;
  // Blocks, of which the average never holds more than the last so many: slow changes are followed.
  static constexpr double kMostBlocks = 200.0;
  // Below this line of a block's spectrum, 5 to 10 Hz, the unsettled model and its arm's resonance
  // count most, and what springs answer to a torque's noise makes less of it.
  static constexpr int kFirstLine = 5;
  static constexpr int kMostBins = 96;
  // Of a block may be spread, which leaves a quarter of the power of white noise at the sensor: its
  // deviation is then found 4 % too small at most.
  static constexpr int kMostSpread = 10;  // one sample in so many

  struct Bin {
    int first;       // line
    int end;         // line behind its last
    double cosine;   // of the bin's frequency
    double density;  // (rad/s)^2, averaged
  };
  using Point = std::array<double, 4>;  // ln sd of kick, its pole, ln sd of sensor, its pole

  /// Blocks of so many samples, or the nearest power of two that there is room for.
  void lay_out(int size);
  bool take(double m, bool spread);
  void take_block();
  void fit();
  double cost(const Point& p) const;
  Point improved(Point p) const;

  int size_ = 0;  // of a block
  std::array<double, kMostBlock> block_{};
  std::array<std::complex<double>, kMostBlock> lines_{};
  std::array<std::complex<double>, kMostBlock / 2> turns_{};
  std::array<double, kMostBlock> taper_{};
  std::array<Bin, kMostBins> bins_{};
  int bin_count_ = 0;
  int filled_ = 0;
  std::array<int, 2> spread_{};  // in each half of the block
  int blocks_ = 0;
  int fewest_blocks_;
  NoisePair noise_;
};

}  // namespace armukf
