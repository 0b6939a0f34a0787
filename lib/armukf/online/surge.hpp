#pragma once

#include <algorithm>

namespace armukf {

/// Mean squares of whitened innovations: of long, and of the last half second.
class Surge {
 public:
  static constexpr double kLatelyS = 0.5;

  /// Takes the mean square over `length` s. `memory_s`: how far back the usual one reaches.
  void add(double power, double length, double memory_s) {
    lately_ += std::min(1.0, length / kLatelyS) * (power - lately_);
    usual_ += std::min(1.0, length / memory_s) * (power - usual_);
  }
  double usual() const { return usual_; }
  double lately() const { return lately_; }

  void forget_latest() { lately_ = usual_; }
  /// What is now is the usual from now on.
  void accept_latest() { usual_ = lately_; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(usual_, lately_);
  }

 private:
  double usual_ = 1.0;
  double lately_ = 1.0;
};

}  // namespace armukf
