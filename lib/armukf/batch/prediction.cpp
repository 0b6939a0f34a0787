#include "armukf/batch/prediction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <type_traits>
#include <utility>

#include "armukf/batch/directions_at_once.hpp"
#include "armukf/batch/gains.hpp"
#include "armukf/batch/noise_likelihood.hpp"
#include "armukf/batch/noise_search.hpp"
#include "armukf/batch/state_step.hpp"
#include "armukf/batch/visit_states.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/filter/kalman.hpp"
#include "armukf/filter/linearised.hpp"
#include "armukf/fit/golden_section.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/ode/propagate.hpp"

namespace armukf {
namespace {

/// Sums over a filter's innovations, the sensor's noise variance taken for 1.
struct InnovationSums {
  double count = 0.0;
  double nis = 0.0;
  double log_variance = 0.0;

  void add(const Innovation& innovation) {
    nis += innovation.nis();
    log_variance += std::log(innovation.variance);
    count += 1.0;
  }

  InnovationSums& operator+=(const InnovationSums& more) {
    count += more.count;
    nis += more.nis;
    log_variance += more.log_variance;
    return *this;
  }

  /// The sensor's variance with which the mean NIS is 1.
  double sensor_variance() const { return nis / count; }

  double log_likelihood() const {
    return -0.5 *
           (count * (std::log(2.0 * std::numbers::pi * sensor_variance()) + 1.0) + log_variance);
  }
};

/// The states of the arm alone, and those of any model, the noises of sensor and torque beside
/// them.
using ArmShape = FixedShape<kArmStates, 0>;
using FewShape = BoundedShape<8, 8>;
using AnyShape = BoundedShape<kMaxStates, kMaxStates>;
using WideShape = BoundedShape<kMaxStates + 2, kMaxStates + 2>;

template <class Shape>
using Rule = LinearisedBy<Shape, kManyAtOnce, kFewAtOnce>;

/// What the filter needs to know of a record.
struct Setting {
  const Model& model;
  const std::vector<double>& x0;
  const std::vector<Sample>& samples;
  const Propagation& propagation;
  FilterNoise noise{0.0};

  int states() const { return static_cast<int>(model.states.size()); }
  double begin() const { return propagation.begin(samples[0].t); }  // s, of effects

  /// Noises that have a colour are states behind the model's.
  bool sensor_coloured() const { return noise.sensor_pole != 0.0; }
  bool torque_coloured() const { return noise.torque_pole != 0.0; }
  int sensor_row() const { return states(); }
  int torque_row() const { return states() + (sensor_coloured() ? 1 : 0); }
  int rows() const { return torque_row() + (torque_coloured() ? 1 : 0); }
};

/// Steps for the numbers by which the filter differentiates.
template <class Shape>
class LinearisedStep {
 public:
  explicit LinearisedStep(const Setting& setting)
      : many_(setting.model, setting.samples, setting.propagation),
        few_(setting.model, setting.samples, setting.propagation) {}

  template <class Number>
  const StateStep<Number>& of() const {
    if constexpr (std::is_same_v<Number, Many>) {
      return many_;
    } else {
      return few_;
    }
  }

 private:
  using Many = typename Rule<Shape>::Many;
  using Few = typename Rule<Shape>::Few;

  StateStep<Many> many_;
  StateStep<Few> few_;
};

/// White torque noise as variance added to each state per second.
template <class Shape>
StepNoise<Shape> noise_per_second(const Setting& setting) {
  const std::array<double, kMassCount> mobility = usual_mobilities(setting.model.values().data());
  StepNoise<Shape> noise{};
  for (int i = 0; i < kMassCount; ++i) {
    if (i == kDrivenMass ? !setting.torque_coloured() : !setting.noise.motor_alone)
      noise[kMasses[i].speed] = std::pow(mobility[i] * setting.noise.density, 2);
  }
  return noise;
}

/// What drives the motor's torque noise where it has a colour ((rad/s^2)^2 s): over the time
/// between two samples the variance by which it grows from one to the next.
double torque_drive(const Setting& setting) {
  const double mobility = usual_mobilities(setting.model.values().data())[kDrivenMass];
  return std::pow(mobility * setting.noise.density * (1.0 - setting.noise.torque_pole), 2);
}

/// States where a filter over a record begins.
template <class Shape>
Gaussian<Shape> first_belief(const Setting& setting, Shape shape) {
  Gaussian<Shape> belief;
  belief.shape = shape;
  for (int i = 0; i < setting.states(); ++i) {
    const double sd = first_spread(setting.model.states[i]);
    belief.mean[i] = setting.x0[i];
    belief.covariance[i][i] = sd * sd;
  }
  if (setting.sensor_coloured())
    belief.covariance[setting.sensor_row()][setting.sensor_row()] = 1.0;
  if (setting.torque_coloured() && setting.samples.size() > 1) {
    const double dt = setting.samples[1].t - setting.samples[0].t;
    belief.covariance[setting.torque_row()][setting.torque_row()] =
        torque_drive(setting) / dt / (1.0 - std::pow(setting.noise.torque_pole, 2));
  }
  return belief;
}

/// What a measurement made of a belief.
template <class Shape>
struct Update {
  Innovation innovation;
  BeliefRow<Shape> covariance;  // of the belief before it and the measurement
};

/// The belief at sample k given the speed y.
template <class Shape>
Update<Shape> updated(const Setting& setting, Gaussian<Shape>& belief, const Rule<Shape>& rule,
                      const LinearisedStep<Shape>& step, std::size_t k) {
  constexpr double kRest = 1e-9;  // of the noise's variance: all of it is in its row
  const auto shown = [&]<class Number>(const Number* x) {
    std::array<Number, Shape::kStates> states;
    std::copy_n(x, Shape::kStates, states.begin());
    Number y = step.template of<Number>().measured(states, k);
    if (setting.sensor_coloured()) y += x[setting.sensor_row()];
    return y;
  };
  const Measurement<Shape> speed = rule.measurement(belief.shape, belief.mean, shown);
  Update<Shape> update{
      innovation(belief, speed, setting.samples[k].y, setting.sensor_coloured() ? kRest : 1.0),
      speed.covariance(belief)};
  condition(belief, update.covariance, update.innovation);
  return update;
}

/// Who is called with the states believed at sample k, given the measurements before and at it; and
/// who with what each measurement made of the belief. No templates: a filter is compiled once per
/// shape.
template <class Shape>
using Visit = std::function<void(std::size_t k, const BeliefRow<Shape>& x)>;
template <class Shape>
using See = std::function<void(std::size_t k, const Update<Shape>& update)>;

/// An extended Kalman filter of the states over the record, the sensor's noise variance 1.
template <class Shape>
InnovationSums filter(const Setting& setting, Shape shape, const Visit<Shape>& visit,
                      const See<Shape>& see) {
  const LinearisedStep<Shape> step(setting);
  const Rule<Shape> rule;
  const StepNoise<Shape> noise = noise_per_second<Shape>(setting);
  constexpr int kDriven = kMasses[kDrivenMass].speed;
  const double sensor_pole = setting.noise.sensor_pole;
  const double torque_pole = setting.noise.torque_pole;
  const double drive = torque_drive(setting);
  const bool sensor_coloured = setting.sensor_coloured();
  const bool torque_coloured = setting.torque_coloured();
  const int sensor_row = setting.sensor_row();
  const int torque_row = setting.torque_row();
  Gaussian<Shape> belief = first_belief(setting, shape);
  InnovationSums sums;
  const std::vector<Sample>& samples = setting.samples;
  const std::size_t faded = first_faded(samples);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k > 0) {
      const double dt = samples[k].t - samples[k - 1].t;
      const auto f = [&]<class Number>(const Number* x, const Number* /*unknowns*/) {
        std::array<Number, Shape::kStates> moved{};
        std::copy_n(x, shape.states(), moved.begin());
        if (torque_coloured) moved[kDriven] += 0.5 * dt * x[torque_row];
        step.template of<Number>()(moved, k);
        if (torque_coloured) moved[kDriven] += 0.5 * dt * x[torque_row];
        if (sensor_coloured) moved[sensor_row] = sensor_pole * x[sensor_row];
        if (torque_coloured) moved[torque_row] = torque_pole * x[torque_row];
        return moved;
      };
      StepNoise<Shape> variance = dt * noise;
      if (sensor_coloured) variance[sensor_row] = 1.0 - sensor_pole * sensor_pole;
      if (torque_coloured) variance[torque_row] = drive / dt;
      move_to(belief, rule(belief, f), variance);
    }
    if (!std::isnan(samples[k].y)) {
      const Update<Shape> update = updated(setting, belief, rule, step, k);
      if (k >= faded) sums.add(update.innovation);
      if (see) see(k, update);
    }
    if (k % kTracesDropped == 0) drop_traces(belief);
    if (visit) visit(k, belief.mean);
  }
  return sums;
}

/// Calls visit(k, y) with the predicted speed at every `stride`-th sample k from `horizon` on;
/// returns the innovations' sums.
template <class Shape>
InnovationSums visit_predictions(const Setting& setting, Shape shape, std::size_t horizon,
                                 std::size_t stride,
                                 const std::function<void(std::size_t, double)>& visit) {
  const StateStep<double> step(setting.model, setting.samples, setting.propagation);
  const auto predict = [&](std::size_t k, const BeliefRow<Shape>& belief) {
    if (k + horizon >= setting.samples.size() || k % stride != 0) return;
    std::array<double, Shape::kStates> x{};
    std::copy_n(belief.begin(), shape.states(), x.begin());
    for (std::size_t i = 1; i <= horizon; ++i) step(x, k + i);
    visit(k + horizon, step.measured(x, k + horizon));
  };
  return filter<Shape>(setting, shape, predict, nullptr);
}

template <class Shape>
Gains gains_of(const Setting& setting, Shape shape) {
  const std::size_t n = setting.samples.size();
  const int states = setting.states();
  Gains gains{.states = states,
              .sensor_pole = setting.noise.sensor_pole,
              .torque_pole = setting.noise.torque_pole,
              .rows = std::vector<double>(n * states, 0.0),
              .torque_noise = std::vector<double>(setting.torque_coloured() ? n : 0, 0.0),
              .innovation_sd = std::vector<double>(n, kInfinite)};
  const auto note = [&](std::size_t k, const Update<Shape>& update) {
    for (int i = 0; i < states; ++i)
      gains.rows[k * states + i] = update.covariance[i] / update.innovation.variance;
    if (setting.torque_coloured())
      gains.torque_noise[k] = update.covariance[setting.torque_row()] / update.innovation.variance;
    gains.innovation_sd[k] = std::sqrt(update.innovation.variance);
  };
  filter<Shape>(setting, shape, nullptr, note);
  return gains;
}

/// Calls visit(shape) with the shape of what the filter believes; all calls return the same type.
template <class Visit>
auto with_state_shape(const Setting& setting, Visit visit) {
  const int rows = setting.rows();
  if (rows == kArmStates) return visit(ArmShape{});
  if (rows <= FewShape::kStates) return visit(FewShape{rows, rows});
  if (rows <= AnyShape::kStates) return visit(AnyShape{rows, rows});
  return visit(WideShape{rows, rows});
}

/// The density whose predictions are best, the sensor's noise white.
template <class Shape>
double best_density(Setting setting, Shape shape, std::size_t horizon) {
  constexpr double kLeast = -8.0;         // ln of N.m.s^1/2 per rad/s: only the sensor is noisy
  constexpr double kMost = 6.0;           // only the torque is
  constexpr std::size_t kPerHorizon = 4;  // predictions that overlap more tell little more
  const std::size_t stride = std::max<std::size_t>(1, horizon / kPerHorizon);
  return std::exp(golden_section(kLeast, kMost, [&](double x) {
    double sum = 0.0;
    setting.noise.density = std::exp(x);
    visit_predictions(setting, shape, horizon, stride, [&](std::size_t k, double y) {
      const double error = y - setting.samples[k].y;
      if (!std::isnan(setting.samples[k].y)) sum += error * error;
    });
    return std::isnan(sum) ? kInfinite : sum;
  }));
}

/// Predictions at several horizons, each by the model of its part: as many at once as a register
/// holds, each from its own sample on.
class PredictionsAhead {
 public:
  PredictionsAhead(const Setting& setting, std::span<const int> horizons, const PartModels& parts)
      : setting_(setting),
        horizons_(horizons),
        parts_(parts),
        all_(horizons.size(), std::vector<double>(setting.samples.size(), kNaN)),
        waiting_(horizons.size()) {
    for (const Model& model : parts.models) values_.push_back(model.values());
    if (values_.empty()) values_.push_back(setting.model.values());
  }

  /// From those states, believed at sample k; of N rows, the first of which are the model's.
  template <std::size_t N>
  void predict(std::size_t k, const std::array<double, N>& belief) {
    const std::size_t n = setting_.samples.size();
    for (std::size_t h = 0; h < horizons_.size(); ++h) {
      const auto horizon = static_cast<std::size_t>(horizons_[h]);
      const std::size_t half = std::max<std::size_t>(1, horizon / 2);
      const std::size_t first = k + horizon - half + 1;
      if (k % half != 0 || first >= n) continue;
      const std::size_t last = std::min(k + horizon, n - 1);
      for (int part = part_of(first); part <= part_of(last); ++part) {
        Begun begun{k, first, last, part, {}};
        while (part_of(begun.first) < part) ++begun.first;
        while (part_of(begun.last) > part) --begun.last;
        std::copy_n(belief.begin(), setting_.states(), begun.x.begin());
        waiting_[h].push_back(begun);
        if (waiting_[h].size() == kPackWidth) go_on(h);
      }
    }
  }

  /// rad/s, for each horizon at each sample; NaN where nothing was predicted.
  std::vector<std::vector<double>> take() {
    for (std::size_t h = 0; h < horizons_.size(); ++h) go_on(h);
    return std::move(all_);
  }

  /// The same where what was to be predicted from sample k on cannot be: infinite there.
  std::vector<std::vector<double>> take_until(std::size_t k) {
    std::vector<std::vector<double>> all = take();
    for (std::vector<double>& y : all)
      for (std::size_t i = k; i < y.size(); ++i)
        if (std::isnan(y[i])) y[i] = kInfinite;
    return all;
  }

 private:
  /// A prediction of samples first to last, by the model of that part.
  struct Begun {
    std::size_t k;  // from the states at that sample
    std::size_t first;
    std::size_t last;
    int part;
    std::array<double, kMaxStates> x;
  };
  using States = Rows<Lanes<kPackWidth>, kMaxStates>;

  int part_of(std::size_t k) const { return parts_.models.empty() ? 0 : parts_.part[k]; }

  /// Takes those that wait to their ends, a lane each.
  void go_on(std::size_t h) {
    std::vector<Begun>& begun = waiting_[h];
    if (begun.empty()) return;
    const auto of_lane = [&](int lane) -> const Begun& {
      return begun[std::min<std::size_t>(lane, begun.size() - 1)];
    };
    std::array<Pack, kMaxParameters> parameters;
    States x;
    std::size_t longest = 0;
    for (int lane = 0; lane < kPackWidth; ++lane) {
      const Begun& b = of_lane(lane);
      const std::vector<double>& values = values_[b.part];
      for (std::size_t i = 0; i < values.size(); ++i) parameters[i][lane] = values[i];
      for (int i = 0; i < setting_.states(); ++i) x[i][lane] = b.x[i];
      longest = std::max(longest, b.last - b.k);
    }
    const Dynamics<Pack> dynamics(setting_.model, parameters.data());
    for (std::size_t step = 1; step <= longest; ++step) {
      const auto sample = [&](int lane) {
        return std::min(of_lane(lane).k + step, of_lane(lane).last);
      };
      const Pack y = moved(dynamics, sample, x);
      for (std::size_t lane = 0; lane < begun.size(); ++lane) {
        const std::size_t k = begun[lane].k + step;
        if (k < begun[lane].first || k > begun[lane].last) continue;
        all_[h][k] = std::isnan(y[lane]) ? kInfinite : y[lane];
      }
    }
    begun.clear();
  }

  /// Moves each lane's states from the sample before to sample(lane), by as many steps as it takes
  /// alone; returns what the sensor shows of them there.
  template <class SampleOf>
  Pack moved(const Dynamics<Pack>& dynamics, SampleOf sample, States& x) const {
    const std::vector<Sample>& samples = setting_.samples;
    Pack u;
    Pack from;
    Pack dt;
    Pack next_u;
    std::array<int, kPackWidth> steps;
    for (int lane = 0; lane < kPackWidth; ++lane) {
      const std::size_t k = sample(lane);
      u[lane] = samples[k - 1].u;
      from[lane] = samples[k - 1].t - setting_.begin();
      dt[lane] = samples[k].t - samples[k - 1].t;
      next_u[lane] = samples[k].u;
      steps[lane] = steps_over(setting_.propagation, dt[lane]);
    }
    const auto f = [&](const States& state, States& rate, double share) {  // of what lies between
      Rows<Pack, kMaxStates> its_rate;
      dynamics.derivative(from + share * dt, u, point(state).data(), its_rate.data());
      for (int i = 0; i < setting_.states(); ++i) rate[i].packs[0] = dt * its_rate[i];
    };
    const auto take = [&](States& states, int count) {
      take_steps(setting_.propagation.stepper, f, states, 0.0, 1.0, count, setting_.states());
    };
    if (std::ranges::count(steps, steps[0]) == kPackWidth) {
      take(x, steps[0]);
    } else {  // before one of them lies a longer interval
      const States before = x;
      for (int lane = 0; lane < kPackWidth; ++lane) {
        States after = before;
        take(after, steps[lane]);
        for (int i = 0; i < setting_.states(); ++i) x[i][lane] = after[i][lane];
      }
    }
    return dynamics.measured(from + dt, next_u, point(x).data());
  }

  Rows<Pack, kMaxStates> point(const States& x) const {
    Rows<Pack, kMaxStates> row;
    for (int i = 0; i < setting_.states(); ++i) row[i] = x[i].packs[0];
    return row;
  }

  const Setting& setting_;
  std::span<const int> horizons_;
  const PartModels& parts_;
  std::vector<std::vector<double>> values_;  // of the parameters, by part
  std::vector<std::vector<double>> all_;
  std::vector<std::vector<Begun>> waiting_;  // at each horizon
};

template <class Shape>
Prediction predict_ahead(Setting setting, Shape shape, std::size_t horizon) {
  const std::size_t n = setting.samples.size();
  const std::vector<Sample> first(setting.samples.begin(),
                                  setting.samples.begin() + std::min(horizon, n));
  Prediction prediction;
  // Nothing has been measured yet, the angle neither.
  prediction.y =
      simulate(setting.model, setting.x0, first, setting.propagation, Angles::kSimulated);
  prediction.y.resize(n, kNaN);
  setting.noise.density = best_density(setting, shape, horizon);
  const InnovationSums sums = visit_predictions(
      setting, shape, horizon, 1, [&](std::size_t k, double y) { prediction.y[k] = y; });
  prediction.sensor_sd = std::sqrt(sums.sensor_variance());
  prediction.log_likelihood = sums.log_likelihood();
  prediction.torque_density = setting.noise.density * prediction.sensor_sd;
  return prediction;
}

}  // namespace

double first_spread(const Coordinate& state) {
  switch (state.motive) {
    case Motive::kTwist:
      return kTwistSpread;
    case Motive::kSpeed:
      return kSpeedSpread;
    default:
      return state.spread;
  }
}

std::size_t first_faded(const std::vector<Sample>& samples) {
  constexpr double kFadedS = 1.0;     // s
  constexpr double kMostFaded = 0.1;  // of a short record
  if (samples.empty()) return 0;
  const double begin = samples.front().t;
  const double faded = begin + std::min(kFadedS, kMostFaded * (samples.back().t - begin));
  return std::ranges::lower_bound(samples, faded, {}, &Sample::t) - samples.begin();
}

Prediction predict_ahead(const Model& model, const std::vector<double>& x0,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         int horizon) {
  const Setting setting{model, x0, samples, propagation};
  return with_state_shape(setting,
                          [&](auto shape) { return predict_ahead(setting, shape, horizon); });
}

std::vector<std::vector<double>> predictions_at(const Model& model, const std::vector<double>& x0,
                                                const std::vector<Sample>& samples,
                                                const Propagation& propagation, double density,
                                                std::span<const int> horizons,
                                                const PartModels& parts) {
  const Setting setting{model, x0, samples, propagation, {density}};
  PredictionsAhead ahead(setting, horizons, parts);
  with_state_shape(setting, [&]<class Shape>(Shape shape) {
    const auto predict = [&](std::size_t k, const BeliefRow<Shape>& belief) {
      std::array<double, Shape::kStates> x{};
      std::copy_n(belief.begin(), shape.states(), x.begin());
      ahead.predict(k, x);
    };
    filter<Shape>(setting, shape, predict, nullptr);
  });
  return ahead.take();
}

std::vector<std::vector<double>> predictions_at(const Model& model, const std::vector<double>& x0,
                                                const std::vector<Sample>& samples,
                                                const Propagation& propagation, const Gains& gains,
                                                std::span<const int> horizons) {
  const Setting setting{model, x0, samples, propagation};
  const PartModels one_for_all;
  PredictionsAhead ahead(setting, horizons, one_for_all);
  const auto predict = [&](std::size_t k, auto x, double y) {
    if (!std::isnan(samples[k].y)) correct(model, gains, k, samples[k].y - y, x);
    ahead.predict(k, x);
  };
  return ahead.take_until(visit_states(model, model.values(), x0, samples, propagation,
                                       recorded_input<double>(samples), predict, Angles::kMeasured,
                                       gains));
}

Gains filter_gains(const Model& model, const std::vector<double>& x0,
                   const std::vector<Sample>& samples, const Propagation& propagation,
                   const FilterNoise& noise) {
  const Setting setting{model, x0, samples, propagation, noise};
  return with_state_shape(setting, [&](auto shape) { return gains_of(setting, shape); });
}

double log_likelihood(const Model& model, const StatesOfPieces& x0,
                      const std::vector<Record>& pieces, const Propagation& propagation,
                      const FilterNoise& noise) {
  InnovationSums all;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const Setting setting{model, x0[e], pieces[e].samples, propagation, noise};
    all += with_state_shape(setting, [&]<class Shape>(Shape shape) {
      return filter<Shape>(setting, shape, nullptr, nullptr);
    });
  }
  const double found = all.log_likelihood();
  return std::isnan(found) ? -kInfinite : found;
}

FilterNoise likeliest_noise(const Model& model, const StatesOfPieces& x0,
                            const std::vector<Record>& pieces, const Propagation& propagation,
                            const std::optional<FilterNoise>& near, TorqueNoise torque) {
  constexpr std::size_t kEnough = 20000;  // samples of a piece
  constexpr std::size_t kEnoughOfAll = 80000;
  constexpr std::size_t kForALook = 3000;
  constexpr double kLookedAlong = 0.1;  // a density, from which any other is not too far
  constexpr double kUsualTorquePole = 0.8;
  constexpr int kSteps = 6;
  constexpr int kStepsNear = 1;  // whoever begins near will come again
  const auto losses_over = [&](std::size_t most, const FilterNoise& along) {
    std::vector<Record> parts;
    parts.reserve(pieces.size());
    for (const Record& piece : pieces) {
      const std::size_t of_each = std::min(most, kEnoughOfAll / pieces.size());
      const auto count = static_cast<std::ptrdiff_t>(std::min(of_each, piece.samples.size()));
      parts.push_back({piece.name, {piece.samples.begin(), piece.samples.begin() + count}});
    }
    return NoiseLikelihood(model, x0, parts, propagation, along);
  };
  if (near) {
    NoiseSearch search(*near, losses_over(kEnough, *near), torque);
    FilterNoise elsewhere = *near;
    elsewhere.motor_alone = !near->motor_alone;
    search.near(elsewhere);
    search.polish(kStepsNear);
    return search.best();
  }
  const NoiseSearch::Losses at_a_look = losses_over(kForALook, {kLookedAlong});
  std::array<std::optional<NoiseSearch>, 2> found;
  for_each_job(static_cast<int>(found.size()), [&](int i) {
    const bool motor_alone = i == 0;
    std::vector<FilterNoise> places;
    for (const double sensor_pole : {0.0, 0.3, 0.6, 0.9})
      for (const double torque_pole : {0.0, kUsualTorquePole})
        if (torque_pole == 0.0 || (motor_alone && torque == TorqueNoise::kColoured))
          places.push_back({1.0, sensor_pole, torque_pole, motor_alone});
    NoiseSearch look(places.front(), at_a_look, torque);
    look.anywhere(places);
    found[i].emplace(look.best(), losses_over(kEnough, look.best()), torque);
    found[i]->polish(kSteps);
  });
  return (found[1]->loss() < found[0]->loss() ? found[1] : found[0])->best();
}

}  // namespace armukf
