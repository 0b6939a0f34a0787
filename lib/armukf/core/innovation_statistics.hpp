#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "armukf/core/statistics.hpp"

namespace armukf {

/// Statistics of a filter's innovations as they come, in constant memory.
class InnovationStatistics {
 public:
  /// A measurement y and what was predicted for it (rad/s), the innovation over its standard
  /// deviation, and the measurement's log-likelihood given those before.
  void add(double y, double predicted, double normalised_innovation, double log_likelihood);

  /// A sample without a measurement that counts: it keeps its place in time.
  void skip() { remember(0.0); }

  std::size_t count() const { return count_; }
  double fit_percent() const;
  double rmse() const;  // rad/s
  /// 1 for an honest filter; of the later part of the samples, and so is the next: what a filter
  /// finds in the first ones are its start values. Up to kShort samples count all; from then on
  /// more than the last half.
  double mean_nis() const;
  double ljung_box_p() const;  // of the normalised innovations
  /// Sum of their squared autocorrelations, over kWhitenessLags, less what white noise has of it.
  double colour() const;
  /// Their density at the lowest frequencies over the mean one. Below 1 where a filter allows for
  /// more slow disturbance than there is.
  double slow_density() const;
  static constexpr std::size_t kShort = 4096;
  double log_likelihood() const { return log_likelihood_; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(count_, offset_, sum_y_, sum_y2_, sum_error2_, log_likelihood_, late_, later_, past_,
            newest_);
    newest_ = std::clamp(newest_, 0, kWindow - 1);  // it is an index, whoever wrote the archive
  }

 private:
  static constexpr int kWindow = 32;  // lags kept, whole vector registers
  static_assert(kWhitenessLags < kWindow);
  std::array<double, kWhitenessLags> autocorrelation() const;
  void remember(double normalised_innovation);
  void forget_early();

  std::size_t count_ = 0;
  double offset_ = 0.0;  // first y: sums about it do not cancel
  double sum_y_ = 0.0;
  double sum_y2_ = 0.0;
  double sum_error2_ = 0.0;
  double log_likelihood_ = 0.0;
  /// Sums of normalised innovations e since some sample.
  struct Late {
    std::size_t count = 0;
    double squares = 0.0;
    std::array<double, kWindow> products{};  // [k - 1]: sum over t of e_t e_{t-k}

    template <class Archive>
    void archive(Archive& archive) {
      archive(count, squares, products);
    }
  };
  Late late_;                               // since the last but one power of two of the count
  Late later_;                              // since the last one
  std::array<double, 2 * kWindow> past_{};  // from newest_ on: the last innovations, newest first
  int newest_ = 0;
};

}  // namespace armukf
