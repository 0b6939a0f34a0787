#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/online/change_name.hpp"
#include "armukf/online/predictor_bank.hpp"

namespace armukf {

/// The last seconds, sample by sample, to go over them again: where resonances move, what a change
/// adds to the innovations is far from proportional to it, and each change is tried with predictors
/// that have its size. Each pass is a step of Gauss and Newton for all of them.
template <int N>
class ChangeReplay {
 public:
  ChangeReplay(const Model& model, const Propagation& propagation)
      : model_(&model), bank_(model, propagation), kept_(kKept) {}

  /// Makes room for so many changes: to go over the samples allocates nothing then.
  void reserve(std::size_t changes) {
    trials_.reserve(changes);
    tried_.reserve(changes);
    sums_.reserve(changes);
    conditions_.reserve(1 + kPredictors * changes);
    bank_.reserve(conditions_.capacity());
  }

  /// Keeps a sample: t (s), after the one before by dt (s).
  void keep(double t, double dt, double u, double y) {
    kept_[next_ % kKept] = {t, dt, u, y};
    ++next_;
  }
  /// What is believed after the last sample.
  void remember(const typename PredictorBank<N>::Belief& belief) { remember(belief, next_); }
  /// What came before does not hang together with what comes.
  void interrupt() { memory_ = 0; }

  /// Begins with these amounts in a condition, and an onset (s), from which it looks further off
  /// as well where it is to go far.
  void begin(double onset, std::span<const double> amounts, bool far) {
    trials_.resize(amounts.size());
    for (std::size_t i = 0; i < amounts.size(); ++i)
      trials_[i] = {.amount = amounts[i], .onset = onset};
    scan_ = 0;
    scans_ = far ? static_cast<int>(kScanned.size()) : 1;
  }

  /// Goes over them once.
  void pass(const Condition& before, const std::vector<Changeable>& what,
            const PredictorNoise& noise, double sample_s, const OutlierGate& gate) {
    const Memory* memory = memory_before(earliest_onset());
    if (memory == nullptr) return;
    conditions_.assign(1, before);
    tried_.clear();
    for (std::size_t i = 0; i < what.size(); ++i) {
      if (trials_[i].given_up) continue;
      tried_.push_back(i);
      const double a = trials_[i].amount;
      const auto within = [&](double amount) {
        return amount_within(*model_, before, what[i], amount);
      };
      const double probe = scans() ? within(kScanned[scan_]) : a + kProbe;
      const double other = scans() ? within(-kScanned[scan_]) : a;
      for (const double amount : {a, probe, other})
        conditions_.push_back(altered(before, what[i], amount * what[i].usual));
    }
    sums_.assign(tried_.size(), {});
    set_up_bank(*memory, noise, sample_s);
    go_over(
        bank_, memory->next, gate, [&](double t) { hold(t); },
        [&](double e, double t, std::int64_t) { add(e, t); });
    for (std::size_t k = 0; k < tried_.size(); ++k) {
      const std::size_t i = tried_[k];
      if (scans()) {
        choose(trials_[i], sums_[k], kScanned[scan_]);
      } else {
        improve(trials_[i], sums_[k]);
      }
      trials_[i].amount = amount_within(*model_, before, what[i], trials_[i].amount);
    }
    if (scans()) ++scan_;
  }

  /// Those whose statistic is less than half the best one, and by more than `behind`, are not gone
  /// over again.
  void give_up(double behind) {
    double best = 0.0;
    for (const Hypothesis& t : trials_) best = std::max(best, t.statistic);
    for (Hypothesis& t : trials_)
      t.given_up = t.given_up || t.statistic < std::min(0.5 * best, best - behind);
  }

  /// The first time (s) from which on samples can be gone over, if there is one.
  std::optional<double> earliest() const {
    const Memory* memory = memory_before(-kInfinite);
    if (memory == nullptr) return std::nullopt;
    return kept_[(memory->next - 1) % kKept].t;
  }

  /// Lets `bank`, just frozen, see all samples that can be gone over, and leaves it where they end.
  /// It begins with `caution` times the deviations that were believed.
  /// with(e, t): takes its innovation; true where what it believes then is to be remembered, for
  /// what was remembered is forgotten: it was another bank's, off by more than that one knew.
  template <class With>
  void catch_up(PredictorBank<N>& bank, const OutlierGate& gate, double caution, With with) {
    const Memory* oldest = memory_before(-kInfinite);
    if (oldest == nullptr) return;
    Memory start = *oldest;
    for (auto& row : start.belief.covariance)
      for (double& p : row) p *= caution * caution;
    interrupt();
    bank.believe(start.belief);
    go_over(
        bank, start.next, gate, [](double) {},
        [&](double e, double t, std::int64_t next) {
          if (memory_ > 0 && !with(e, t)) return;
          remember(bank.belief(), next);
        });
  }

  /// What `other` takes from the sum of squares of all samples until then (s) that can be gone
  /// over, had it always been so.
  double gained_by(const Condition& other, const Condition& before, double until,
                   const PredictorNoise& noise, double sample_s, const OutlierGate& gate) {
    const Memory* memory = memory_before(-kInfinite);
    if (memory == nullptr) return 0.0;
    conditions_.assign({before, other});
    set_up_bank(*memory, noise, sample_s);
    double gained = 0.0;
    go_over(
        bank_, memory->next, gate, [](double) {},
        [&](double e, double t, std::int64_t) {
          if (t <= until) gained += e * e - std::pow(bank_.innovation(1), 2);
        });
    return gained;
  }

  const std::vector<Hypothesis>& trials() const { return trials_; }

  template <class Archive>
  void archive(Archive& archive) {
    for (Kept& k : kept_) archive(k.t, k.dt, k.u, k.y);
    for (Memory& m : memories_) archive(m.next, m.belief);
    archive(next_, memory_, trials_, scan_, scans_);
    scans_ = std::clamp(scans_, 0, static_cast<int>(kScanned.size()));
    scan_ = std::clamp(scan_, 0, scans_);
    next_ = std::max<std::int64_t>(next_, 0);
    memory_ = std::max<std::int64_t>(memory_, 0);
    for (Memory& m : memories_) m.next = std::clamp<std::int64_t>(m.next, 0, next_);
  }

 private:
  static constexpr int kKept = 8192;      // samples, 4 s at 2 kHz
  static constexpr int kMemories = 80;    // of 50 ms
  static constexpr double kProbe = 0.05;  // of the usual size
  static constexpr int kPredictors = 3;   // of a change: as it is tried, and what is tried next
  static constexpr std::array kScanned{1.0, 3.0};  // usual sizes, either way: the first passes
  static constexpr double kLongestStep = 0.4;
  static constexpr double kFirstOnsetStep = 0.06;  // s

  struct Kept {
    double t = 0.0;
    double dt = 0.0;
    double u = 0.0;
    double y = 0.0;
  };
  struct Memory {
    std::int64_t next = 0;  // the first sample that it has not seen
    typename PredictorBank<N>::Belief belief;
  };
  struct Sums {
    double gained = 0.0;        // e0^2 - e^2
    double gained_probe = 0.0;  // the same with the probing amount,
    double gained_other = 0.0;  // and from the other onset
    double dd = 0.0;
    double de = 0.0;
    double left = 0.0;
    double samples = 0.0;
  };

  /// The first condition of the k-th that is tried.
  static int first_of(std::size_t k) { return 1 + kPredictors * static_cast<int>(k); }

  double earliest_onset() const {
    double earliest = kInfinite;
    for (const Hypothesis& t : trials_)
      if (!t.given_up) earliest = std::min(earliest, t.onset - std::max(0.0, -t.onset_step));
    return earliest;
  }

  /// The last belief before t (s), or the first there still is.
  const Memory* memory_before(double t) const {
    const Memory* found = nullptr;
    for (std::int64_t i = std::max<std::int64_t>(0, memory_ - kMemories); i < memory_; ++i) {
      const Memory& m = memories_[i % kMemories];
      if (next_ - m.next >= kKept - TorqueMemory::kSize - 1) continue;
      if (found == nullptr || kept_[(m.next - 1) % kKept].t <= t) found = &m;
    }
    return found;
  }

  /// The same of what was believed before sample number `next`.
  void remember(const typename PredictorBank<N>::Belief& belief, std::int64_t next) {
    memories_[memory_ % kMemories] = {next, belief};
    ++memory_;
  }

  /// The bank that goes over them, in all conditions, at a memory.
  void set_up_bank(const Memory& memory, const PredictorNoise& noise, double sample_s) {
    bank_.freeze(conditions_, noise, sample_s);
    bank_.believe(memory.belief);
  }

  /// Lets `bank` predict the samples from number `first` on. at(t): before each is predicted from
  /// t (s); with(e, t, next): after, unless it was an outlier, `next` being the number of the next.
  template <class At, class With>
  void go_over(PredictorBank<N>& bank, std::int64_t first, const OutlierGate& gate, At at,
               With with) {
    int astray = 0;
    TorqueMemory u;
    for (std::int64_t k = first - TorqueMemory::kSize; k < first - 1; ++k)
      if (k >= 0) u.take(kept_[k % kKept].u);
    for (std::int64_t k = first; k < next_; ++k) {
      const Kept& now = kept_[k % kKept];
      const Kept& last = kept_[(k - 1) % kKept];
      u.take(last.u);
      at(last.t);
      bank.predict(last.t, now.dt, u);
      if (std::isnan(now.y)) continue;
      const double e = bank.update(now.t, now.y, gate.width(astray));
      if (!gate.shuts_out(e, astray)) with(e, now.t, k + 1);
    }
  }

  /// Until its onset a machine is what it was.
  void hold(double t) {
    for (std::size_t k = 0; k < tried_.size(); ++k) {
      const Hypothesis& trial = trials_[tried_[k]];
      const int first = first_of(k);
      if (t < trial.onset) {
        bank_.join(first);
        bank_.join(first + 1);
      }
      if (t < trial.onset + trial.onset_step) bank_.join(first + 2);
    }
  }

  void add(double e, double t) {
    for (std::size_t k = 0; k < tried_.size(); ++k) {
      Sums& s = sums_[k];
      const Hypothesis& trial = trials_[tried_[k]];
      const int first = first_of(k);
      if (t > trial.onset) {
        const double own = bank_.innovation(first);
        const double probe = bank_.innovation(first + 1);
        s.gained += e * e - own * own;
        s.gained_probe += e * e - probe * probe;
        const double d = (own - probe) * (1.0 / kProbe);
        s.dd += d * d;
        s.de += d * own;
        s.left += own * own;
        s.samples += 1.0;
      }
      if (t > trial.onset + trial.onset_step) {
        const double other = bank_.innovation(first + 2);
        s.gained_other += e * e - other * other;
      }
    }
  }

  /// Whether the next pass looks where to begin: a resonance that has moved far pulls from nearby
  /// and from its own side only.
  bool scans() const { return scan_ < scans_; }

  void choose(Hypothesis& trial, const Sums& s, double scanned) const {
    const double best = std::max({s.gained, s.gained_probe, s.gained_other});
    if (s.gained_probe == best) trial.amount = scanned;
    if (s.gained_other == best) trial.amount = -scanned;
    if (scan_ + 1 == scans_) trial.onset_step = kFirstOnsetStep;
  }

  static void improve(Hypothesis& trial, const Sums& s) {
    if (!std::isfinite(s.gained + s.dd + s.de)) {  // the change makes a machine that is none
      trial.amount *= 0.5;
      trial.statistic = 0.0;
      return;
    }
    trial.statistic = s.gained;
    trial.information = s.dd;
    trial.left = s.left;
    trial.samples = s.samples;
    if (s.gained_other > s.gained) {
      trial.onset += trial.onset_step;
    } else {
      trial.onset_step *= trial.onset_step > 0.0 ? -1.0 : -0.5;
    }
    trial.last_step = std::clamp(s.de / (1.0 + s.dd), -kLongestStep, kLongestStep);
    trial.amount += trial.last_step;
  }

  const Model* model_;
  PredictorBank<N> bank_;
  std::vector<Kept> kept_;
  std::int64_t next_ = 0;
  std::array<Memory, kMemories> memories_;
  std::int64_t memory_ = 0;
  std::vector<Condition> conditions_;
  std::vector<Hypothesis> trials_;
  int scan_ = 0;                    // of kScanned, what the next pass tries
  int scans_ = 0;                   // of them, so many
  std::vector<std::size_t> tried_;  // those not given up
  std::vector<Sums> sums_;          // of them
};

}  // namespace armukf
