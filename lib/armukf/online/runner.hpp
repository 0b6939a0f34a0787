#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "armukf/core/segments.hpp"
#include "armukf/online/engine.hpp"
#include "armukf/online/session.hpp"

namespace armukf {

/// How a belief came from one sample to the next.
enum class Passage {
  kMoved,       // by the arm's equations
  kStatesAnew,  // the states at rest again, the parameters as believed
  kAllAnew      // the parameters with their prior spread as well
};

/// What a step made of its sample.
struct RunnerStep {
  Status status;
  Innovation innovation;
  bool used;  // the measurement has gone into the belief

  /// For the tally and the user, still without what is believed.
  Estimate estimate(const Sample& sample) const {
    return {.sample = sample,
            .predicted = innovation.predicted,
            .innovation = innovation.value,
            .innovation_sd = std::sqrt(innovation.variance),
            .nis = innovation.nis(),
            .log_likelihood = used ? innovation.log_likelihood() : 0.0,
            .status = status,
            .values = {},
            .deviations = {}};
  }
};

/// A filter that goes through the samples, and knows what to do with gaps, missing measurements,
/// outliers, and numbers that went wrong.
template <class Filter>
class Runner {
 public:
  Runner(Engine<Filter> engine, const Gate& gate)
      : engine_(std::move(engine)), gate_(gate), is_gap_(gate.longest_gap_s) {}

  /// One that has seen nothing, of the same model and settings.
  Runner anew() const { return Runner(engine_.anew(), gate_); }

  Engine<Filter>& engine() { return engine_; }
  const Engine<Filter>& engine() const { return engine_; }

  /// Of all measurements; one that was rejected counts as if it lay just at the gate, so that no
  /// filter gains by refusing what it cannot explain.
  double log_likelihood() const { return log_likelihood_; }

  /// Counts from the next measurement on.
  void forget_likelihood() { log_likelihood_ = 0.0; }

  /// Of the last step.
  Passage passage() const { return passage_; }
  const Moment& moment() const { return now_; }

  /// How many samples before the last one have shown the same number.
  int still() const { return rests_.still(); }

  RunnerStep step(const Sample& sample) {
    if (!last_) first_time_ = sample.t;
    now_.at_rest = rests_(sample.y);
    const Status before = predict(sample);
    last_ = sample;
    // Rounding may make the belief indefinite, in the measured row or in another.
    const Innovation innovation = engine_.innovation(sample.y);
    if (!(innovation.variance > 0.0)) return reset(sample);
    const Status after = update(sample, innovation);
    if (!engine_.is_sound()) return reset(sample);
    return {before == Status::kOk ? after : before, innovation, after == Status::kOk};
  }

  /// All that samples have made of it.
  template <class Archive>
  void archive(Archive& archive) {
    archive(engine_, is_gap_, rests_, last_, first_time_, idle_s_, now_.t, now_.watched,
            log_likelihood_, rejected_in_a_row_, passage_);
    rejected_in_a_row_ = std::clamp(rejected_in_a_row_, 0, gate_.patience);
    now_.at_rest = rests_.is_at_rest();
    if (last_) engine_.begin_at({});  // it has begun
  }

 private:
  /// Brings the belief to the sample's time; a gap is none to learn in.
  Status predict(const Sample& sample) {
    passage_ = Passage::kStatesAnew;
    if (!last_) {
      engine_.believe_rest(sample.y);
      return Status::kOk;
    }
    const double dt = sample.t - last_->t;
    const Moment before = now_;
    now_.t = sample.t - first_time_;
    const bool gap = is_gap_(dt);
    if (gap || now_.at_rest) idle_s_ += dt;
    now_.watched = now_.t - idle_s_;
    if (gap) {
      engine_.believe_rest(sample.y);
      return Status::kGap;
    }
    if (engine_.predict(before, dt, last_->u)) {
      passage_ = Passage::kMoved;
      return Status::kOk;
    }
    passage_ = Passage::kAllAnew;
    engine_.restart(sample.y);
    return Status::kReset;
  }

  Status update(const Sample& sample, const Innovation& innovation) {
    if (std::isnan(sample.y)) return Status::kMissing;
    if (!(innovation.nis() <= gate_.nis)) {
      log_likelihood_ += innovation.log_likelihood_at(gate_.nis);
      engine_.reject(innovation, now_);
      if (++rejected_in_a_row_ < gate_.patience) return Status::kRejected;
      rejected_in_a_row_ = 0;
      engine_.believe_rest(sample.y);
      if (passage_ == Passage::kMoved) passage_ = Passage::kStatesAnew;
      return Status::kReset;
    }
    rejected_in_a_row_ = 0;
    log_likelihood_ += innovation.log_likelihood();
    engine_.update(innovation, now_);
    return Status::kOk;
  }

  /// Begins anew at a sample, which is not taken into the belief any more.
  RunnerStep reset(const Sample& sample) {
    passage_ = Passage::kAllAnew;
    engine_.restart(sample.y);
    return {Status::kReset, engine_.innovation(sample.y), false};
  }

  Engine<Filter> engine_;
  Gate gate_;
  GapWatch is_gap_;
  RestWatch rests_;
  std::optional<Sample> last_;
  double first_time_ = 0.0;
  double idle_s_ = 0.0;  // in gaps and at rest: no time to learn in
  Moment now_;
  double log_likelihood_ = 0.0;
  int rejected_in_a_row_ = 0;
  Passage passage_ = Passage::kStatesAnew;
};

}  // namespace armukf
