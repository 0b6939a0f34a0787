#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/filter/covariance_filter.hpp"
#include "armukf/filter/noise_adaptation.hpp"
#include "armukf/filter/noise_spectrum.hpp"
#include "armukf/filter/score_spread.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/ode/propagate.hpp"
#include "armukf/online/moment.hpp"
#include "armukf/online/noise_watch.hpp"
#include "armukf/online/race.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// Noises that have a memory, as states of the belief behind those of the model: the driven mass's
/// torque noise (N.m) and the sensor's (rad/s). Poles are those of one step, `kick` is half of what
/// a torque adds to the mass's speed during the step, (rad/s)/(N.m).
struct ColourStep {
  double torque_pole = 0.0;
  double sensor_pole = 0.0;
  double half_kick = 0.0;
};
inline constexpr int kColourStates = 2;

/// The arm from one sample to the next, as a filter's f(x, theta): states x and free coordinates z
/// in, states after dt out. T is double, Dual or Lanes.
template <int N>
struct ArmStep {
  const Model& model;
  const FreeCoordinates& coordinates;
  const Propagation& propagation;
  double t;   // s, since the first sample
  double dt;  // s
  double u;   // N.m
  bool coloured = false;
  ColourStep colour{};

  template <class T>
  std::array<T, N> operator()(const T* x, const T* z) const {
    std::array<T, N> moved;
    const int states = static_cast<int>(model.states.size());
    if (coloured) {
      move<true>(x, z, states, moved);
    } else {
      move<false>(x, z, states, moved);
    }
    return moved;
  }

 private:
  /// The torque's noise acts half before the motion, half after it.
  template <bool Coloured, class T>
  void move(const T* x, const T* z, int states, std::array<T, N>& moved) const {
    constexpr int kRows = N == kArmStates + kColourStates ? kArmStates : N;
    constexpr int kDriven = kMasses[kDrivenMass].speed;
    std::array<T, kRows> arm;
    std::copy_n(x, states, arm.begin());
    std::fill(arm.begin() + states, arm.end(), T());
    if constexpr (Coloured) arm[kDriven] += colour.half_kick * x[states];
    const System<T, kRows> system(model, coordinates, z, u);
    propagate(propagation, system, arm, t, dt, rows_in_use<decltype(arm)>(model));
    if constexpr (Coloured) arm[kDriven] += colour.half_kick * x[states];
    std::copy_n(arm.begin(), states, moved.begin());
    if constexpr (Coloured) {
      moved[states] = colour.torque_pole * x[states];
      moved[states + 1] = colour.sensor_pole * x[states + 1];
    }
  }
};

/// What the sensor shows, as a filter's h(x, theta).
struct ArmSensor {
  const Model& model;
  const FreeCoordinates& coordinates;
  int states;
  double t;            // s, since the first sample
  double u;            // N.m
  int noise_row = -1;  // of the sensor's coloured noise, if the belief has it

  /// x: the rows of the belief, states first.
  template <class T>
  T operator()(const T* x) const {
    std::array<T, kMaxParameters> p;
    coordinates.to_physical(x + states, p.data());
    T y = Dynamics<T>(model, p.data()).measured(t, u, x);
    if (noise_row >= 0) y += x[noise_row];
    return y;
  }
};

/// A filter at work on the arm.
template <class Filter>
class Engine {
 public:
  using Shape = typename Filter::Shape;

  Engine(const Model& model, const FreeCoordinates& coordinates, const EstimatorSettings& settings,
         Filter filter)
      : model_(&model), coordinates_(&coordinates), settings_(&settings), filter_(filter) {
    acts_on_sensor_ = model.acts_on_sensor();
    coloured_ = states() == own_states() + kColourStates;
    noise_.sensor.sd = settings.noise.sensor;
    model_error_ = settings.noise.model_error.start * settings.noise.model_error.start;
    torque_density_ = armukf::torque_noise(settings.noise, model.heaviness());
    adapts_ = is_adaptive(settings.filter);
    if (adapts_) adaptation_ = NoiseAdaptation(settings.adaptation);
  }

  /// One that has seen nothing, of the same model and settings.
  Engine anew() const {
    Filter filter(filter_.shape(), settings_->spread);
    return Engine(*model_, *coordinates_, *settings_, filter);
  }

  /// Believes these parameters (one value per parameter of the model) with their prior spread.
  void believe_parameters(const std::vector<double>& p) {
    std::array<double, kMaxParameters> z;
    coordinates_->from_physical(p, z.data());
    const int first = states();
    std::copy_n(z.begin(), coordinates_->size(), filter_.mean().begin() + first);
    refresh_parameters();
    for (int k = 0; k < coordinates_->size(); ++k)
      filter_.forget(first + k, believed_spread_ * prior_sd(k));
    scores_ = {};
    widening_ = filled_with_one();
    began_at_ = {};
  }

  /// Goes on from what an earlier estimate believed, and remembers it: what contradicts it is told
  /// with a wider deviation. Unknowns that are `held` stay put: they are believed far narrower than
  /// they are told.
  void go_on_from(const ParameterBelief& earlier, const std::vector<int>& held) {
    constexpr double kHeld = 0x1p-10;  // of the deviation
    PerUnknown part = filled_with_one();
    for (const int k : held) part[k] = kHeld;
    if (!believe(earlier, part)) part = filled_with_one();
    for (int k = 0; k < coordinates_->size(); ++k)
      began_at_[k] = {filter_.mean()[states() + k], part[k] / std::sqrt(free_covariance(k, k)),
                      1.0 / part[k]};
  }

  /// Believes what was believed elsewhere; believe_parameters came before. Unknowns of which that
  /// knows nothing keep their prior. A covariance that is none is left out.
  void believe(const ParameterBelief& earlier) { believe(earlier, filled_with_one()); }

  /// The same, and never learns another noise than its.
  void keep(const ParameterBelief& earlier) {
    keeps_noise_ = true;
    believe(earlier);
  }

  /// Where angles and phases begin with the first sample.
  void begin_at(const std::vector<Place>& places) { places_ = places; }

  /// Believes the springs at rest and all masses at the speed y (rad/s), with the prior spread; at
  /// any speed where y is NaN. Angles and phases are where they begin the first time, and later
  /// anywhere.
  void believe_rest(double y) {
    const bool measured = !std::isnan(y);
    for (int i = 0; i < own_states(); ++i) {
      const Coordinate& state = model_->states[i];
      filter_.mean()[i] = state.beginning == Beginning::kSpeed && measured ? y : 0.0;
      filter_.forget(i, i == kMeasuredState ? measured_sd(measured) : prior_sd(state));
    }
    for (const Place& place : places_) {
      filter_.mean()[place.state] = place.value;
      filter_.forget(place.state, place.sd);
    }
    places_.clear();
    if (coloured_) {
      believe_noise(torque_row(), torque_noise());
      believe_noise(sensor_row(), noise_.sensor);
    }
    watch_.interrupt();
  }

  /// Begins with these parameters (one per parameter of the model), in their prior spread, and with
  /// the noise that `first` has learnt, of the same model, or that part of the torque's. What is
  /// learnt of the noise begins anew.
  void look_again(const Engine& first, const std::vector<double>& p, double part_of_torque) {
    believed_spread_ = first.believed_spread_;
    believe_parameters(p);
    noise_ = first.noise_;
    noise_.kick.sd *= part_of_torque;
    learnt_ = first.learnt_;
    model_error_ = 0.0;
    opening_ = settings_->noise.model_error.start * settings_->noise.model_error.start;
  }

  /// What was seen lately was of a machine that has changed: the noise is learnt anew, and until
  /// then what is reckoned with stays. What is not noise is told anew as well.
  void begin_noise_anew() {
    watch_ = NoiseWatch::after_change(usual_dt_);
    samples_ = 0;
    seen_ = 0.0;
    expected_ = 0.0;
  }

  /// The noise that was learnt, if it is noise and there was enough to learn it from; and how much
  /// of the innovations is none.
  LearntNoise learnt_noise() const {
    LearntNoise found;
    found.sought = learnt_ || (coloured_ && watch_.has_learnt());
    found.known = learnt_;
    found.sample_s = usual_dt_;
    found.not_noise = not_noise();
    if (!learnt_) return found;
    const ColouredNoise torque = torque_noise();
    found.torque_sd = torque.sd;
    found.torque_pole = torque.pole;
    found.sensor_sd = noise_.sensor.sd;
    found.sensor_pole = noise_.sensor.pole;
    return found;
  }

  /// Starts anew after the numbers went wrong: states at rest, and the parameters as last believed
  /// (from the start if that is no number), with half the spread that they had at the last start: a
  /// prior that reaches beyond what an arm can be would only fail again. Nobody is told that half:
  /// deviations are those of the whole prior. A noise that was learnt may have been what was wrong.
  void restart(double y) {
    constexpr double kLeast = 1.0 / 16;  // of the prior's
    believed_spread_ = std::max(kLeast, 0.5 * believed_spread_);
    if (!keeps_noise_) forget_noise();
    std::vector<double> p;
    for (std::size_t i = 0; i < model_->parameters.size(); ++i)
      p.push_back(std::isfinite(parameters_[i]) ? parameters_[i] : model_->parameters[i].value);
    believe_parameters(p);
    believe_rest(y);
  }

  /// Moves the belief over dt (s) from a moment on under the held torque u (N.m). Returns false,
  /// and leaves the belief as it was, where the numbers went wrong.
  bool predict(const Moment& from, double dt, double u) {
    const Interval interval{from.t, dt, u};
    kick_ = dt * mobilities(parameters_.data())[kDrivenMass];
    const double torque = coloured_ ? filter_.mean()[torque_row()] : 0.0;
    if (!filter_.predict(arm_step(interval), step_noise(from, dt))) return false;
    last_ = interval;
    since_update_s_ += dt;
    kicked_ += kick_ * torque;
    return true;
  }

  Innovation innovation(double y) const {
    const double variance = sensor_variance() + model_error_ + opening_;
    if (acts_on_sensor_) return filter_.innovation(arm_sensor(), y, variance);
    return filter_.innovation(measured_row(), y, variance);
  }

  /// Takes the innovation into the belief, and into what is thought of the model's error.
  void update(const Innovation& innovation, const Moment& at) {
    const double before = believed_speed(innovation.predicted);
    if (acts_on_sensor_) {
      filter_.update(arm_step(last_), arm_sensor(), innovation);
    } else {
      filter_.update(arm_step(last_), measured_row(), innovation);
    }
    coordinates_->keep_inside(filter_.mean().begin() + states());
    if (coloured_) learn(innovation, before, at);
    look_at_scores(at.watched);
    if (adapts_) {
      adapt(innovation, at.watched);
    } else {
      const ModelError& error = settings_->noise.model_error;
      follow_model_error(innovation, at.watched, error.gain, error.time_s);
    }
    refresh_parameters();
  }

  /// Leaves an outlier out of the belief. To an adaptive filter it still tells of noise: else one
  /// that trusts itself too much would reject all that could correct it.
  void reject(const Innovation& innovation, const Moment& at) {
    if (adapts_) adapt(innovation, at.watched);
  }

  /// Whether every variance of the belief is one, and its motor has not run away.
  bool is_sound() const {
    if (!(std::abs(filter_.mean()[kMeasuredState]) < kRunawaySpeed)) return false;
    for (int i = 0; i < filter_.shape().size(); ++i)
      if (const double v = filter_.covariance(i, i); !(v > 0.0 && std::isfinite(v))) return false;
    return true;
  }

  /// Where this belief would be after dt (s), and how that hangs together with it. For filters that
  /// keep their covariance.
  struct Prediction {
    Image<Shape> image;
    Gaussian<Shape> belief;
  };
  Prediction prediction(const Gaussian<Shape>& belief, const Moment& from, double dt, double u) {
    filter_.believe(belief);
    refresh_parameters();
    Prediction ahead{filter_.image(arm_step({from.t, dt, u})), belief};
    move_to(ahead.belief, ahead.image, step_noise(from, dt));
    return ahead;
  }

  const Filter& filter() const { return filter_; }

  /// The noise of the driven mass's torque (N.m), held for a step; none where it is not learnt.
  ColouredNoise torque_noise() const {
    return {kick_ > 0.0 ? noise_.kick.sd / kick_ : 0.0, noise_.kick.pole};
  }

  /// Covariance of the physical values of two unknowns, to be believed: that of the belief, widened
  /// where stretches of the samples contradict each other, or what it began with.
  double covariance(int i, int j) const {
    const auto P = [&](int a, int b) { return free_covariance(a, b); };
    return told(i) * told(j) * coordinates_->physical_covariance(i, j, parameters_.data(), P);
  }

  /// Deviations of all unknowns, of the same.
  void deviations(double* sd) const {
    believed_deviations(sd);
    for (int k = 0; k < coordinates_->size(); ++k) sd[k] *= told(k);
  }

  /// Variance of a free coordinate, widened where stretches of the samples contradict each other.
  double free_variance(int k) const { return squared(by_stretches(k)) * free_covariance(k, k); }

  /// Deviations as the belief has them.
  void model_deviations(double* sd) const {
    believed_deviations(sd);
    for (int k = 0; k < coordinates_->size(); ++k) sd[k] *= began_at_[k].narrowed;
  }

  /// Part of the innovations' mean square that is beyond what the noise explains, 0 to 1, of the
  /// later part of the samples.
  double not_noise() const {
    return seen_ > 0.0 ? std::clamp(1.0 - expected_ / seen_, 0.0, 1.0) : 0.0;
  }

  /// The believed value of each parameter of the model.
  const double* parameters() const { return parameters_.data(); }

  /// All that samples have made of it; the rest is of model and settings.
  template <class Archive>
  void archive(Archive& archive) {
    archive(filter_, noise_, watch_, learnt_, kick_, usual_dt_, since_update_s_, kicked_, opening_);
    for (Begun& began : began_at_) archive(began.z, began.precision, began.narrowed);
    archive(scores_, widening_, scored_at_, scores_keep_, samples_, seen_, expected_, since_fade_,
            faded_at_);
    if (!scores_.fits(coordinates_->size())) throw InputError("has scores of other unknowns");
    archive(believed_spread_, last_.t, last_.dt, last_.u, parameters_, model_error_, adaptation_,
            updated_at_);
  }

 private:
  using PerUnknown = std::array<double, Shape::kSize>;

  /// As large as there may be unknowns, so that a belief can be changed while it runs without
  /// allocating.
  class SmallSquare {
   public:
    double& operator()(int i, int j) { return entries_[i][j]; }
    double operator()(int i, int j) const { return entries_[i][j]; }

   private:
    std::array<std::array<double, kMaxParameters>, kMaxParameters> entries_{};
  };

  static constexpr double kLeastSpeedSd =
      1e-3;                                    // rad/s: a belief without sensor noise stays regular
  static constexpr double kAnySpeedSd = 30.0;  // rad/s: what an axis of a robot may be doing
  static constexpr double kLeastWeight = 1e-5;   // of a sample in a mean: of the last minute
  static constexpr double kWhitePart = 1e-4;     // of the sensor's variance: keeps S regular
  static constexpr double kOpeningStays = 0.97;  // a sample, of the noise that stands for the
                                                 // states at the first sample: gone after 0.1 s
  static constexpr double kLeastNoise = 1e-9;    // 1/s^1/2: the belief's root does not degenerate

  /// What held during an interval between samples.
  struct Interval {
    double t = 0.0;   // s, of its begin
    double dt = 0.0;  // s
    double u = 0.0;   // N.m
  };

  /// Covariance of the unknowns' physical values, the prior's where the earlier belief has none.
  SmallSquare with_prior(const ParameterBelief& earlier) const {
    const int n = coordinates_->size();
    const auto place = [&](int k) {
      return earlier.place_of(model_->parameters[coordinates_->unknowns()[k]].name);
    };
    const auto prior = [&](int i, int j) { return i == j ? prior_sd(i) * prior_sd(i) : 0.0; };
    SmallSquare sum;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        if (place(i) >= 0 && place(j) >= 0) {
          sum(i, j) = earlier.covariance(place(i), place(j));
        } else if (i == j) {
          sum(i, j) = coordinates_->physical_covariance(i, j, parameters_.data(), prior);
        }
      }
    return sum;
  }

  /// The same with a part of each deviation only; false where it is left out.
  bool believe(const ParameterBelief& earlier, PerUnknown part) {
    const int n = coordinates_->size();
    const SmallSquare physical = with_prior(earlier);
    const auto free = [&](int i, int j) {
      return coordinates_->free_covariance(i, j, parameters_.data(), physical);
    };
    constexpr double kWider = 2.0;       // than any prior may be, of what was found
    constexpr double kRounding = 1e-10;  // of a variance, of what it may be told by others
    for (int k = 0; k < n; ++k)
      part[k] *= std::min(1.0, kWider * most_sd(k) / std::sqrt(free(k, k)));
    SmallSquare L;
    for (int j = 0; j < n; ++j) {
      for (int i = j; i < n; ++i) {
        double sum = part[i] * part[j] * free(i, j);
        for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
        if (i > j) {
          L(i, j) = sum / L(j, j);
          continue;
        }
        const double rounding = kRounding * part[j] * part[j] * free(j, j);
        if (!(sum > -rounding)) return false;
        L(j, j) = std::sqrt(std::max(sum, rounding));
      }
    }
    filter_.believe_block(states(), n, L);
    if (coloured_ && earlier.noise.known) believe(earlier.noise);
    return true;
  }

  double measured_sd(bool measured) const {
    return measured ? std::max(settings_->noise.sensor, kLeastSpeedSd) : kAnySpeedSd;
  }

  double prior_sd(const Coordinate& state) const {
    if (state.motive == Motive::kTwist) return settings_->prior.twist;
    return state.motive == Motive::kSpeed ? settings_->prior.speed : state.spread;
  }

  double sensor_variance() const {
    if (coloured_) return kWhitePart * noise_.sensor.sd * noise_.sensor.sd;
    const double sd = settings_->noise.sensor * adaptation_.sensor_factor();
    return sd * sd;
  }

  MeasuredRow measured_row() const { return {kMeasuredState, coloured_ ? sensor_row() : -1}; }
  int torque_row() const { return own_states(); }
  int sensor_row() const { return own_states() + 1; }

  void believe_noise(int row, const ColouredNoise& noise) {
    filter_.mean()[row] = 0.0;
    filter_.forget(row, std::max(noise.sd, kLeastSpeedSd));
  }

  /// rad/s; of the measurement that is (or is going to be) `shown`, without the sensor's noise.
  double believed_speed(double shown) const {
    return coloured_ ? shown - filter_.mean()[sensor_row()] : shown;
  }

  /// What lies between the last update and this one.
  Between between() const {
    constexpr double kMany = 1e6;
    const double intervals = usual_dt_ > 0.0 ? std::min(since_update_s_ / usual_dt_, kMany) : 1.0;
    return {std::max(1, static_cast<int>(std::lround(intervals))), kicked_};
  }

  void learn(const Innovation& innovation, double before, const Moment& at) {
    if (usual_dt_ == 0.0) watch_ = NoiseWatch(usual_dt_ = last_.dt);
    opening_ *= kOpeningStays;
    fade(at.watched);
    if (keeps_noise_) return;
    const double after = believed_speed(shown_now());
    if (at.at_rest) watch_.interrupt();
    if (watch_.see(innovation, before, after, between())) take_noise(watch_.noise());
    since_update_s_ = 0.0;
    kicked_ = 0.0;
  }

  /// rad/s, what the sensor would show of the belief as it is.
  double shown_now() const {
    if (acts_on_sensor_) return arm_sensor()(filter_.mean().begin());
    return measured_row()(filter_.mean().begin());
  }

  /// Reckons with what was learnt if it can be noise.
  void take_noise(const NoisePair& learnt) {
    const double density =
        std::sqrt(learnt.kick.long_run_variance() * last_.dt) / std::max(kick_, 1e-300);
    learnt_ = density <= most_torque_noise(settings_->noise, model_->heaviness());
    noise_ = learnt_ ? learnt : unlearnt_noise();
  }
  NoisePair unlearnt_noise() const { return {{}, {settings_->noise.sensor, 0.0}}; }

  void forget_noise() {
    watch_ = NoiseWatch(usual_dt_);
    learnt_ = false;
    noise_ = unlearnt_noise();
    model_error_ = std::max(model_error_, squared(settings_->noise.model_error.start));
  }

  void believe(const LearntNoise& noise) {
    kick_ = noise.sample_s * mobilities(parameters_.data())[kDrivenMass];
    noise_ = {{noise.torque_sd * kick_, noise.torque_pole}, {noise.sensor_sd, noise.sensor_pole}};
    learnt_ = true;
    opening_ = std::exchange(model_error_, 0.0);
  }

  /// Lets what was learnt of the parameters count less as it grows old; a deviation never grows
  /// beyond the prior's.
  void fade(double watched) {
    constexpr int kEvery = 64;  // updates
    if (++since_fade_ < kEvery) return;
    since_fade_ = 0;
    const double before = std::exchange(faded_at_, watched);
    const NoiseLearning& l = settings_->noise.learning;
    const bool begins_far_off = !settings_->belief || keeps_noise_;
    if (!learnt_ || watched > l.fade_until_s || !begins_far_off) return;
    const double factor =
        std::pow((watched + l.fade_from_s) / (before + l.fade_from_s), 0.5 * l.fade);
    for (int k = 0; k < coordinates_->size(); ++k)
      if (filter_.deviation(states() + k) < prior_sd(k)) filter_.widen(states() + k, factor);
    scores_keep_ /= factor * factor;
  }

  /// Ends a stretch of samples: by how much the parameters' deviations are to be widened.
  void look_at_scores(double watched) {
    constexpr double kSettled = 1.0;   // s, in which the start values are left
    constexpr double kStretch = 0.25;  // s, longer than the memory of the arm's residual
    if (settings_->noise.model_error.gain == 0.0) return;  // the noise is known as it is given
    if (watched < kSettled || watched - scored_at_ < kStretch) return;
    scored_at_ = watched;
    const int first = states();
    const auto theta = [&](int k) { return filter_.mean()[first + k]; };
    const auto P = [&](int i, int j) { return free_covariance(i, j); };
    if (!scores_.has_begun()) {
      scores_.begin(coordinates_->size(), theta);
    } else {
      scores_.add(theta, P, scores_keep_);
      widen([&](int k) { return scores_.excess(k, P); });
    }
    scores_keep_ = 1.0;
  }

  /// Stretches contradict each other in free coordinates, by so much each; an unknown that hangs
  /// together with others (a share) is widened by what these make of it, and never narrowed.
  template <class Excess>
  void widen(const Excess& excess) {
    PerUnknown by;
    PerUnknown believed;
    for (int k = 0; k < coordinates_->size(); ++k) by[k] = excess(k);
    believed_deviations(believed.data());
    const auto P = [&](int i, int j) { return by[i] * by[j] * free_covariance(i, j); };
    coordinates_->deviations(parameters_.data(), P, widening_.data());
    for (int k = 0; k < coordinates_->size(); ++k)
      widening_[k] = believed[k] > 0.0 ? std::max(1.0, widening_[k] / believed[k]) : 1.0;
  }

  void believed_deviations(double* sd) const {
    const auto P = [&](int i, int j) { return free_covariance(i, j); };
    coordinates_->deviations(parameters_.data(), P, sd);
  }

  double free_covariance(int i, int j) const {
    return filter_.covariance(states() + i, states() + j);
  }

  static double squared(double x) { return x * x; }

  /// What the k-th unknown's deviation is multiplied by where it is told.
  double told(int k) const {
    return is_held(k) ? began_at_[k].narrowed : by_stretches(k) * by_beginning(k);
  }
  double by_stretches(int k) const { return is_held(k) ? 1.0 : widening_[k] * unnarrowed(k); }
  bool is_held(int k) const { return began_at_[k].narrowed > 1.0; }

  /// An earlier estimate's value that these samples leave by more than its deviation contradicts
  /// them: one of both is worth so much less than it says, as R. T. Birge has it (Phys. Rev. 40,
  /// 207, 1932).
  double by_beginning(int k) const {
    const Begun& began = began_at_[k];
    return std::max(1.0, std::abs(filter_.mean()[states() + k] - began.z) * began.precision);
  }

  /// The same for a prior that restarts have narrowed: with the information that samples have added
  /// to it, 1 / P - 1 / P_narrow, the whole one would be 1 / (1 / P_whole + that).
  double unnarrowed(int k) const {
    if (believed_spread_ == 1.0) return 1.0;
    const double narrowed = squared(believed_spread_);
    const double left = free_covariance(k, k) / squared(prior_sd(k));  // of the whole prior's
    return 1.0 / std::sqrt(std::max(narrowed, 1.0 - left * (1.0 / narrowed - 1.0)));
  }

  /// Towards `gain` times the innovation's square, over time_s.
  void follow_model_error(const Innovation& innovation, double watched, double gain,
                          double time_s) {
    const double noise = innovation.variance - model_error_;
    const double weight = std::max(3.0 / (3.0 + samples_), kLeastWeight);
    ++samples_;
    seen_ += weight * (innovation.value * innovation.value - seen_);
    expected_ += weight * (noise - expected_);
    const double expected = learnt_ ? settings_->noise.learning.beyond * noise : 0.0;
    const double seen = gain * (innovation.value * innovation.value - expected);
    model_error_ += std::min(1.0, (watched - updated_at_) / time_s) * (seen - model_error_);
    const double least = settings_->noise.model_error.least;
    model_error_ = std::max(model_error_, least * least);
    updated_at_ = watched;
  }

  /// An adaptive filter takes what it cannot explain for noise of sensor and torque. The model's
  /// error only bridges the beginning; while it counts, nothing is learnt but from innovations that
  /// are beyond it as well.
  void adapt(const Innovation& innovation, double watched) {
    constexpr double kCounts = 0.01;  // of the sensor's variance
    constexpr double kBeyond = 9.0;   // normalised innovation squared
    if (model_error_ < kCounts * sensor_variance() || innovation.nis() > kBeyond)
      adaptation_.learn(innovation, watched - updated_at_);
    follow_model_error(innovation, watched, 0.0, settings_->adaptation.settle_s);
  }

  static PerUnknown filled_with_one() {
    PerUnknown ones;
    ones.fill(1.0);
    return ones;
  }

  int states() const { return filter_.shape().states(); }
  int own_states() const { return static_cast<int>(model_->states.size()); }

  ArmStep<Shape::kStates> arm_step(const Interval& i) const {
    return {*model_,
            *coordinates_,
            settings_->propagation,
            i.t,
            i.dt,
            i.u,
            coloured_,
            {noise_.kick.pole, noise_.sensor.pole, 0.5 * kick_}};
  }

  ArmSensor arm_sensor() const {
    return {*model_,  *coordinates_,
            states(), last_.t + last_.dt,
            last_.u,  coloured_ ? sensor_row() : -1};
  }

  void refresh_parameters() {
    coordinates_->to_physical(filter_.mean().begin() + states(), parameters_.data());
  }

  /// Prior deviation of the k-th free coordinate about the believed value.
  double prior_sd(int k) const {
    return std::min(model_->parameters[coordinates_->unknowns()[k]].spread, most_sd(k));
  }

  /// Of a parameter that reaches further a filter, which looks about its mean, sees nothing but
  /// arms that run away. One that is kept between its bounds does not.
  double most_sd(int k) const {
    constexpr double kMostSpread = 1.5;  // relative: a factor of 4.5 either way
    return coordinates_->is_scaled(k) ? kInfinite : kMostSpread;
  }

  StepNoise<Shape> step_noise(const Moment& from, double dt) const {
    const Noise& noise = settings_->noise;
    const auto variance = [&](double density) {
      return (density * density + kLeastNoise * kLeastNoise) * dt;
    };
    const std::array<double, kMassCount> mobility = mobilities(parameters_.data());
    StepNoise<Shape> sum{};
    for (int i = 0; i < states(); ++i) sum[i] = variance(0.0);
    const double factor = adaptation_.state_factor();
    for (int i = 0; i < kMassCount; ++i)
      sum[kMasses[i].speed] = variance(mobility[i] * torque_density_[i] * factor);
    if (learnt_)
      for (const Mass& mass : kMasses) sum[mass.speed] = variance(0.0);
    if (coloured_) {
      sum[torque_row()] = torque_noise().driving_variance() + variance(0.0);
      sum[sensor_row()] = noise_.sensor.driving_variance();
    }
    // Wear is for those who expect it: what is left once the noise is known is no walk. Nor do
    // parameters leave their places while nothing is seen of them.
    const Annealing& annealed = noise.parameter_walk;
    const double walk = from.at_rest ? 0.0
                        : learnt_    ? annealed.at(from.watched) - annealed.floor
                                     : annealed.at(from.watched);
    for (int k = 0; k < coordinates_->size(); ++k)
      sum[states() + k] = variance(walk / began_at_[k].narrowed);
    return sum;
  }

  const Model* model_;
  const FreeCoordinates* coordinates_;
  const EstimatorSettings* settings_;
  Filter filter_;
  bool acts_on_sensor_ = false;
  bool coloured_ = false;  // whether torque and sensor noise are states
  NoisePair noise_;
  NoiseWatch watch_;
  bool learnt_ = false;
  bool keeps_noise_ = false;
  std::array<double, kMassCount> torque_density_{};  // N.m.s^1/2, as long as nothing is learnt
  double kick_ = 0.0;      // (rad/s)/(N.m), what a torque adds to the driven mass's speed in a step
  double usual_dt_ = 0.0;  // s
  double since_update_s_ = 0.0;
  double kicked_ = 0.0;   // rad/s, by the believed torque noise since the last update
  double opening_ = 0.0;  // (rad/s)^2, variance
  std::vector<Place> places_;
  double believed_spread_ = 1.0;  // of the parameters' prior, with which they began last
  ScoreSpread<Shape::kSize> scores_;
  // What each coordinate's deviation is multiplied by; 1 where the noise is known.
  PerUnknown widening_ = filled_with_one();
  /// What an earlier estimate has left of a free coordinate to begin with, and one over its
  /// deviation, 0 where there was none; and how many times narrower it is believed than told.
  struct Begun {
    double z = 0.0;
    double precision = 0.0;
    double narrowed = 1.0;
  };
  std::array<Begun, Shape::kSize> began_at_{};
  double scored_at_ = 0.0;    // s, watched
  double scores_keep_ = 1.0;  // of the weight of earlier scores, by what faded since the last one
  double samples_ = 0.0;      // used
  double seen_ = 0.0;         // (rad/s)^2, mean square of the innovations, later ones counting more
  double expected_ = 0.0;     // (rad/s)^2, the same as noise and belief explain it
  int since_fade_ = 0;        // updates
  double faded_at_ = 0.0;     // s, watched
  Interval last_;
  std::array<double, kMaxParameters> parameters_{};  // physical, at the belief's mean
  double model_error_;                               // (rad/s)^2, variance
  NoiseAdaptation adaptation_;
  bool adapts_ = false;
  double updated_at_ = 0.0;  // s, watched when the last measurement was used
};

}  // namespace armukf
