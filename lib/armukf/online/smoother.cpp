#include "armukf/online/smoother.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "armukf/core/error.hpp"
#include "armukf/filter/smoothing.hpp"
#include "armukf/online/filters.hpp"
#include "armukf/online/race.hpp"
#include "armukf/online/recursion.hpp"
#include "armukf/online/runner.hpp"
#include "armukf/online/widening.hpp"

namespace armukf {
namespace {

/// Of the points that it takes, root-n deviations away, arms are other ones than about the mean:
/// with the noise as it is it would believe too much. Settings that allow for more make up for
/// that.
constexpr std::string_view kFarReaching = "ckf";

/// What a pass of the filter begins with, and what the passes before say of how far it is to be
/// trusted.
struct Found {
  Model model;
  EstimatorSettings settings;
  std::vector<double> caution = {};  // by which each parameter's deviation is multiplied, if any
  std::vector<std::string> hardly_told = {};
  bool settling = false;
};

/// By how much an estimate's deviations are wider than a belief that takes itself at its word.
std::vector<double> caution_of(const RecursiveEstimate& e) {
  std::vector<double> caution;
  for (std::size_t i = 0; i < e.sd.size(); ++i)
    caution.push_back(e.model_sd[i] > 0.0 ? std::max(1.0, e.sd[i] / e.model_sd[i]) : 1.0);
  return caution;
}

/// The same for the next pass. Where the noise is known by now, it begins from what is believed: as
/// far off as start values may be a filter that knows it would believe too much again. What the
/// samples have said already counts a ninth, by which deviations are 5 % too small. What they have
/// told hardly anything of begins as it did.
Found estimated(const Found& found, std::span<const Sample> samples) {
  constexpr double kWider = 3.0;
  const RecursiveEstimate e = estimate_record(found.model, found.settings, samples);
  Found next{next_start(found.model, e), found.settings, caution_of(e), e.hardly_told,
             found.settling || e.settling};
  for (std::size_t i = 0; i < found.caution.size(); ++i)
    next.caution[i] = std::max(next.caution[i], found.caution[i]);
  ParameterBelief belief = e.belief;
  if (!belief.noise.known || found.settings.filter == kFarReaching) return next;
  for (const std::string& name : e.hardly_told) belief.leave_out(name);
  belief.widen(kWider);
  next.settings.belief = belief;
  next.settings.race.starts = {{}};
  next.settings.noise.parameter_walk.start = next.settings.noise.parameter_walk.floor;
  return next;
}

/// Which start wins the race; the others need no memory of what they believed.
std::size_t winner(const Model& model, const EstimatorSettings& settings,
                   std::span<const Sample> samples) {
  Session session(model, settings);
  for (const Sample& sample : samples) {
    session.step(sample);
    if (session.decided()) break;
  }
  return session.start();
}

/// Beliefs of all samples, each packed as its mean and the lower half of its covariance.
template <class Shape>
class History {
 public:
  History(Shape shape, std::size_t samples) : shape_(shape) {
    numbers_.reserve(samples * size());
    passages_.reserve(samples);
    moments_.reserve(samples);
  }

  void add(const Gaussian<Shape>& belief, Passage passage, const Moment& moment) {
    const int n = shape_.size();
    numbers_.insert(numbers_.end(), belief.mean.begin(), belief.mean.begin() + n);
    for (int i = 0; i < n; ++i)
      numbers_.insert(numbers_.end(), belief.covariance[i].begin(),
                      belief.covariance[i].begin() + i + 1);
    passages_.push_back(passage);
    moments_.push_back(moment);
  }

  Gaussian<Shape> belief(std::size_t k) const {
    Gaussian<Shape> belief;
    belief.shape = shape_;
    const double* next = numbers_.data() + k * size();
    for (int i = 0; i < shape_.size(); ++i) belief.mean[i] = *next++;
    for (int i = 0; i < shape_.size(); ++i)
      for (int j = 0; j <= i; ++j) belief.covariance[i][j] = belief.covariance[j][i] = *next++;
    return belief;
  }

  /// How belief k came about, and when.
  Passage passage(std::size_t k) const { return passages_[k]; }
  const Moment& moment(std::size_t k) const { return moments_[k]; }

 private:
  std::size_t size() const {
    const auto n = static_cast<std::size_t>(shape_.size());
    return n + n * (n + 1) / 2;
  }

  Shape shape_;
  std::vector<double> numbers_;
  std::vector<Passage> passages_;
  std::vector<Moment> moments_;
};

/// The belief about the parameters after the states have started anew: these tell nothing, and so
/// stand where they will be found.
template <class Shape>
Gaussian<Shape> with_states_anew(Gaussian<Shape> belief, const Gaussian<Shape>& after) {
  for (int i = 0; i < belief.shape.states(); ++i) {
    belief.mean[i] = after.mean[i];
    belief.covariance[i] = BeliefRow<Shape>{};
    for (auto& row : belief.covariance) row[i] = 0.0;
    for (int j = 0; j < belief.shape.states(); ++j)
      belief.covariance[i][j] = after.covariance[i][j];
  }
  return belief;
}

template <class Filter>
class Smoother {
 public:
  using Shape = typename Filter::Shape;

  Smoother(const Found& found, const FreeCoordinates& coordinates, const Start& start,
           Filter filter, std::span<const Sample> samples, const SmoothingProgress& progress)
      : coordinates_(coordinates),
        own_states_(static_cast<int>(found.model.states.size())),
        runner_(Engine(found.model, coordinates, found.settings, filter), found.settings.gate),
        history_(filter.shape(), samples.size()),
        samples_(samples),
        progress_(progress),
        caution_(found.caution) {
    result_.hardly_told = found.hardly_told;
    result_.settling = found.settling;
    runner_.engine().believe_parameters(start.values);
    if (found.settings.belief) runner_.engine().keep(*found.settings.belief);
    runner_.engine().begin_at(start.places);
  }

  SmoothedRecord run() {
    forwards();
    backwards();
    return std::move(result_);
  }

 private:
  void forwards() {
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      const RunnerStep step = runner_.step(samples_[k]);
      history_.add(runner_.engine().filter().belief(), runner_.passage(), runner_.moment());
      result_.statuses.push_back(step.status);
      result_.tally.add(step.estimate(samples_[k]));
      tell(0.5 * static_cast<double>(k) / static_cast<double>(samples_.size()), k);
    }
  }

  void backwards() {
    const std::size_t count = samples_.size();
    result_.columns =
        static_cast<std::size_t>(own_states_) + static_cast<std::size_t>(coordinates_.size());
    result_.values.resize(count * result_.columns);
    result_.deviations.resize(result_.values.size());
    Gaussian<Shape> smoothed;
    for (std::size_t k = count; k-- > 0;) {
      Gaussian<Shape> belief = history_.belief(k);
      if (k + 1 < count) look_back(k, belief, smoothed);
      smoothed = belief;
      report(k, smoothed);
      tell(1.0 - 0.5 * static_cast<double>(k) / static_cast<double>(count), k);
    }
  }

  /// belief: filtered at k, becomes smoothed.
  void look_back(std::size_t k, Gaussian<Shape>& belief, const Gaussian<Shape>& after) {
    const Passage passage = history_.passage(k + 1);
    if (passage == Passage::kAllAnew) return;
    if (passage == Passage::kStatesAnew) {
      step_(belief, with_states_anew(belief, after), Image<Shape>(), after);
      return;
    }
    const Sample& sample = samples_[k];
    const auto [image, predicted] = runner_.engine().prediction(
        belief, history_.moment(k), samples_[k + 1].t - sample.t, sample.u);
    step_(belief, predicted, image, after);
  }

  void report(std::size_t k, const Gaussian<Shape>& belief) {
    double* values = result_.values.data() + k * result_.columns;
    double* deviations = result_.deviations.data() + k * result_.columns;
    for (int i = 0; i < own_states_; ++i) {
      values[i] = belief.mean[i];
      deviations[i] = belief.deviation(i);
    }
    const int s = belief.shape.states();  // noises among them
    std::array<double, kMaxParameters> p;
    coordinates_.to_physical(belief.mean.begin() + s, p.data());
    for (int j = 0; j < coordinates_.size(); ++j)
      values[own_states_ + j] = p[coordinates_.unknowns()[j]];
    coordinates_.deviations(
        p.data(), [&](int i, int j) { return belief.covariance[s + i][s + j]; },
        deviations + own_states_);
    if (caution_.empty()) return;
    Widening widening;
    for (int j = 0; j < coordinates_.size(); ++j) {
      const double caution = caution_[coordinates_.unknowns()[j]];
      widening.add(caution, belief.covariance[s + j][s + j]);
      deviations[own_states_ + j] *= caution;
    }
    // States settle with the parameters: once they have, they are as well known as they seem.
    for (int i = 0; i < own_states_ && result_.settling; ++i)
      deviations[i] = std::sqrt(widening.variance(
          belief.covariance[i][i], [&](int j) { return belief.covariance[i][s + j]; }));
  }

  void tell(double share, std::size_t k) const {
    if (progress_ && k % 4096 == 0) progress_(share);
  }

  const FreeCoordinates& coordinates_;
  int own_states_;
  Runner<Filter> runner_;
  History<Shape> history_;
  std::span<const Sample> samples_;
  const SmoothingProgress& progress_;
  const std::vector<double>& caution_;
  SmoothingStep<Shape> step_;
  SmoothedRecord result_;
};

void check_filter(const EstimatorSettings& settings) {
  with_filter("the smoother", SmoothingFilters<PublishedShape>(), settings.filter, PublishedShape{},
              settings.spread, [](const auto& /*filter*/) { return true; });
}

}  // namespace

SmoothedRecord smooth(const Model& model, const EstimatorSettings& settings,
                      std::span<const Sample> samples, int passes,
                      const SmoothingProgress& progress) {
  check_filter(settings);
  Found last{model, settings};
  for (int pass = 1; pass < passes; ++pass) last = estimated(last, samples);
  const FreeCoordinates coordinates(last.model);
  const Start start =
      starts_of(last.model, last.settings.race)[winner(last.model, last.settings, samples)];
  const bool coloured = last.settings.belief && last.settings.belief->noise.known;
  return with_shape(last.model, coordinates, coloured, [&](auto shape) {
    return with_filter("the smoother", SmoothingFilters<decltype(shape)>(), settings.filter, shape,
                       settings.spread, [&](auto filter) {
                         return Smoother(last, coordinates, start, filter, samples, progress).run();
                       });
  });
}

}  // namespace armukf
