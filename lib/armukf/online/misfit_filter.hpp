#pragma once

#include <array>
#include <span>
#include <vector>

namespace armukf {

/// An autoregression of the last steps, and the deviation of what it leaves:
///     x_k = a_1 x_{k-1} + ... + a_p x_{k-p} + sd e_k.
struct Foretelling {
  static constexpr int kOrder = 20;
  std::array<double, kOrder> a{};
  double sd = 1.0;

  template <class Archive>
  void archive(Archive& archive) {
    archive(a, sd);
  }
};

/// Averages rows of innovations over steps of some samples, with weights that rise over one step
/// and fall over the next, so that what is faster than a step does not look slow; and takes off
/// them what an autoregression foretells.
class StepFilter {
 public:
  static constexpr double kStepS = 0.01;

  StepFilter() = default;
  StepFilter(int lanes, double sample_s);

  /// What came before does not hang together with what comes.
  void restart();
  /// Takes the next row; true where a step is full.
  bool add(std::span<const double> row);
  /// Whether there are as many steps before the last one as the autoregression looks back.
  bool remembers() const { return steps_ > Foretelling::kOrder; }
  /// Mean of a lane over the last step, or one that is `ago` steps older.
  double mean(int lane, int ago = 0) const {
    return means_[at((last_ + kKept - ago) % kKept, lane)];
  }
  /// The last step's mean less what is foretold of it, in deviations.
  void rest(const Foretelling& by, std::span<double> row) const;

  template <class Archive>
  void archive(Archive& archive) {
    for (double& v : means_) archive(v);
    for (double& v : rising_) archive(v);
    for (double& v : falling_) archive(v);
    archive(samples_, steps_, last_);
    last_ = (last_ % kKept + kKept) % kKept;
  }

 private:
  static constexpr int kKept = Foretelling::kOrder + 1;
  std::size_t at(int step, int lane) const {
    return static_cast<std::size_t>(step) * rising_.size() + static_cast<std::size_t>(lane);
  }

  std::vector<double> means_;  // a row a step
  std::vector<double> rising_;
  std::vector<double> falling_;
  int length_ = 1;  // samples of a step
  int samples_ = 0;
  int steps_ = 0;
  int last_ = 0;
};

/// What a model lacks is now and then much larger than usual, as where friction turns round. A row,
/// in deviations, whose first lane is beyond chance counts the less, with all its lanes. Source: P.
/// J. Huber, "Robust Statistics", 1981, ch. 7.
void weigh_down(std::span<double> row);

/// Learns such an autoregression by recursive least squares (L. Ljung, "System Identification",
/// 1999, ch. 11).
class ForetellingLearner {
 public:
  /// Takes what the filter's first lane has come to.
  void learn(const StepFilter& filter);
  /// Whether it has seen enough to be of use.
  bool has_learnt() const { return seen_ > Foretelling::kOrder; }
  const Foretelling& foretelling() const { return found_; }
  /// Steps that its deviation is known from.
  int freedom() const { return seen_ - kOrder; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(found_, P_, power_, seen_);
  }

 private:
  static constexpr int kOrder = Foretelling::kOrder;

  Foretelling found_;
  std::array<std::array<double, kOrder>, kOrder> P_{};  // of the coefficients, over the variance
  double power_ = 0.0;                                  // sum of squares of what is left
  int seen_ = 0;                                        // steps
};

}  // namespace armukf
