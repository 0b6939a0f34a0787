#include "armukf/batch/noise_likelihood.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "armukf/batch/directions_at_once.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/batch/state_step.hpp"
#include "armukf/batch/visit_states.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/dual.hpp"
#include "armukf/core/lanes.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr int kPushed = kMasses[kDrivenMass].speed;  // by the torque

/// A noise per lane, as the filter takes it.
struct NoisePack {
  Pack sensor_pole{};
  Pack torque_pole{};
  Pack density{};    // N.m.s^1/2 per rad/s, of the torque that is a state
  Pack at_motor{};   // of a white one at the motor
  Pack at_others{};  // of a white one at the other masses
};

NoisePack packed(const FilterNoise* noises, std::size_t count) {
  NoisePack all;
  for (int lane = 0; lane < kPackWidth; ++lane) {
    const FilterNoise& noise = noises[std::min<std::size_t>(lane, count - 1)];
    const bool coloured = noise.torque_pole != 0.0;
    all.sensor_pole[lane] = noise.sensor_pole;
    all.torque_pole[lane] = noise.torque_pole;
    all.density[lane] = coloured ? noise.density : 0.0;
    all.at_motor[lane] = coloured ? 0.0 : noise.density;
    all.at_others[lane] = noise.motor_alone ? 0.0 : noise.density;
  }
  return all;
}

Pack square(const Pack& v) { return v * v; }

/// Kalman filters of a linear model, one per lane: of S states x, as they differ from those along
/// the way, of the sensor's noise, and of the acceleration by the torque's.
template <int S>
class LinearFilters {
 public:
  LinearFilters(const NoisePack& noise, const std::vector<double>& spread,
                const std::vector<double>& mobility, double interval)
      : noise_(noise) {
    for (std::size_t i = 0; i < spread.size(); ++i) {
      covariance_[i][i] = broadcast(spread[i] * spread[i]);
      const Pack density = i == kPushed ? noise.at_motor : noise.at_others;
      variance_[i] = square(mobility[i] * density);
    }
    drive_ = square(mobility[kPushed] * noise.density * (1.0 - noise.torque_pole));
    sensor_variance_ = broadcast(1.0);
    if (interval > 0.0) torque_variance_ = drive_ / interval / (1.0 - square(noise.torque_pole));
  }

  /// motion: S x S, row by row; torque: that along the way (rad/s^2), over dt (s).
  void move(const double* motion, double torque, double dt) {
    const double half = 0.5 * dt;
    push(half, torque);
    State moved{};
    State with_sensor{};
    State with_torque{};
    for (int i = 0; i < S; ++i)
      for (int k = 0; k < S; ++k) {
        const double f = motion[i * S + k];
        moved[i] += f * mean_[k];
        with_sensor[i] += f * with_sensor_[k];
        with_torque[i] += f * with_torque_[k];
      }
    mean_ = moved;
    with_sensor_ = with_sensor;
    with_torque_ = with_torque;
    Square product;
    for (int i = 0; i < S; ++i) {
      State row{};
      for (int k = 0; k < S; ++k) {
        const double f = motion[i * S + k];
        for (int j = 0; j < S; ++j) row[j] += f * covariance_[k][j];
      }
      product[i] = row;
    }
    for (int i = 0; i < S; ++i)
      for (int j = 0; j <= i; ++j) {
        Pack sum{};
        for (int k = 0; k < S; ++k) sum += motion[j * S + k] * product[i][k];
        covariance_[i][j] = sum;
        covariance_[j][i] = sum;
      }
    push(half, torque);
    for (int i = 0; i < S; ++i) {
      covariance_[i][i] += dt * variance_[i];
      with_sensor_[i] *= noise_.sensor_pole;
      with_torque_[i] *= noise_.torque_pole;
    }
    sensor_ *= noise_.sensor_pole;
    torque_ *= noise_.torque_pole;
    sensor_torque_ *= noise_.sensor_pole * noise_.torque_pole;
    sensor_variance_ =
        square(noise_.sensor_pole) * sensor_variance_ + (1.0 - square(noise_.sensor_pole));
    torque_variance_ =
        square(noise_.torque_pole) * torque_variance_ + (dt > 0.0 ? drive_ / dt : Pack{});
  }

  /// shown: derivatives of what the sensor shows; error: rad/s, of that along the way.
  void update(const double* shown, double error, bool counts) {
    constexpr double kRest = 1e-9;  // of the noise's variance: all of it is in its row
    State Ph = with_sensor_;
    Pack sensor = sensor_variance_;
    Pack torque = sensor_torque_;
    Pack e = error - sensor_;
    for (int k = 0; k < S; ++k) {
      const double h = shown[k];
      if (h == 0.0) continue;
      for (int i = 0; i < S; ++i) Ph[i] += h * covariance_[k][i];
      sensor += h * with_sensor_[k];
      torque += h * with_torque_[k];
      e -= h * mean_[k];
    }
    Pack variance = sensor + kRest;
    for (int k = 0; k < S; ++k) variance += shown[k] * Ph[k];
    const Pack inverse = 1.0 / variance;
    const Pack gain = e * inverse;
    for (int i = 0; i < S; ++i) {
      mean_[i] += gain * Ph[i];
      const Pack K = inverse * Ph[i];
      for (int j = 0; j < S; ++j) covariance_[i][j] -= K * Ph[j];
      with_sensor_[i] -= K * sensor;
      with_torque_[i] -= K * torque;
    }
    sensor_ += gain * sensor;
    torque_ += gain * torque;
    sensor_torque_ -= inverse * sensor * torque;
    sensor_variance_ -= inverse * sensor * sensor;
    torque_variance_ -= inverse * torque * torque;
    if (!counts) return;
    nis_ += e * gain;
    product_ *= variance;
    count_ += 1.0;
  }

  /// What the states along the way were corrected by, they no longer differ by.
  void follow(const double* correction) {
    for (int i = 0; i < S; ++i) mean_[i] -= correction[i];
  }

  /// Keeps all numbers normal; once in a few samples.
  void tidy() {
    constexpr double kTrace = 1e-100;
    for (State& row : covariance_)
      for (Pack& v : row) v = v < kTrace && v > -kTrace ? Pack{} : v;
    for (int lane = 0; lane < kPackWidth; ++lane) log_variance_[lane] += std::log(product_[lane]);
    product_ = broadcast(1.0);
  }

  double count() const { return count_; }
  const Pack& nis() const { return nis_; }
  const Pack& log_variance() const { return log_variance_; }

 private:
  using State = std::array<Pack, S>;
  using Square = std::array<State, S>;

  /// Half of what the torque's noise does to the motor's speed between two samples.
  void push(double half, double torque) {
    mean_[kPushed] += half * (torque_ - torque);
    for (int j = 0; j < S; ++j) {
      if (j == kPushed) continue;
      covariance_[kPushed][j] += half * with_torque_[j];
      covariance_[j][kPushed] = covariance_[kPushed][j];
    }
    covariance_[kPushed][kPushed] += half * (2.0 * with_torque_[kPushed] + half * torque_variance_);
    with_torque_[kPushed] += half * torque_variance_;
    with_sensor_[kPushed] += half * sensor_torque_;
  }

  NoisePack noise_;
  State mean_{};
  Square covariance_{};
  State with_sensor_{};  // covariances of the states with the noises
  State with_torque_{};
  Pack sensor_{};  // rad/s
  Pack torque_{};  // rad/s^2
  Pack sensor_variance_{};
  Pack torque_variance_{};
  Pack sensor_torque_{};
  State variance_{};  // per second
  Pack drive_{};
  Pack nis_{};
  Pack log_variance_{};
  Pack product_ = broadcast(1.0);
  double count_ = 0.0;
};

}  // namespace

template <class Visit>
void NoiseLikelihood::with_states(Visit visit) const {
  const std::size_t states = model_.states.size();
  if (states <= 5) return visit.template operator()<5>();
  if (states <= 6) return visit.template operator()<6>();
  if (states <= 7) return visit.template operator()<7>();
  if (states <= 8) return visit.template operator()<8>();
  if (states <= 12) return visit.template operator()<12>();
  return visit.template operator()<kMaxStates>();
}

NoiseLikelihood::NoiseLikelihood(const Model& model, const StatesOfPieces& x0,
                                 const std::vector<Record>& pieces, const Propagation& propagation,
                                 const FilterNoise& along)
    : model_(model),
      propagation_(propagation),
      mobility_(model.states.size(), 0.0),
      ways_(pieces.size()) {
  for (const Coordinate& state : model.states) spread_.push_back(first_spread(state));
  const std::array<double, kMassCount> mobility = usual_mobilities(model.values().data());
  for (int i = 0; i < kMassCount; ++i) mobility_[kMasses[i].speed] = mobility[i];
  int rows = 0;
  with_states([&]<int S>() { rows = S; });
  for_each_job(static_cast<int>(pieces.size()), [&](int e) {
    ways_[e] = rows <= kFewStates ? way_over<kFewStates>(rows, x0[e], pieces[e].samples, along)
                                  : way_over<kMaxStates>(rows, x0[e], pieces[e].samples, along);
  });
}

template <int Most>
NoiseLikelihood::Way NoiseLikelihood::way_over(int S, const std::vector<double>& x0,
                                               const std::vector<Sample>& samples,
                                               const FilterNoise& along) const {
  using Number = Dual<kFewAtOnce>;
  using States = std::array<Number, Most>;
  const std::size_t n = samples.size();
  Way way;
  way.samples = n;
  way.faded = first_faded(samples);
  way.interval.assign(n, 0.0);
  way.motion.assign(n * S * S, 0.0);
  way.shown.assign(n * S, 0.0);
  way.error.assign(n, kNaN);
  way.correction.assign(n * S, 0.0);
  way.torque.assign(n, 0.0);
  if (n == 0) return way;
  const auto states = static_cast<int>(model_.states.size());
  const Gains gains = filter_gains(model_, x0, samples, propagation_, along);
  const StateStep<Number> step(model_, samples, propagation_);
  std::array<double, Most> x{};
  std::copy_n(x0.begin(), states, x.begin());
  double expected = 0.0;  // rad/s, of the sensor's noise
  double torque = 0.0;    // rad/s^2
  // The states as they are, with derivatives by those from `first` on.
  const auto seeded = [&](int first) {
    States at;
    for (int i = 0; i < Most; ++i) at[i] = Number(x[i]);
    for (int j = first; j < std::min(first + kFewAtOnce, states); ++j)
      at[j].gradient[j - first] = 1.0;
    return at;
  };
  const auto for_each_part = [&](const auto& visit) {
    for (int first = 0; first < states; first += kFewAtOnce)
      visit(first, std::min(kFewAtOnce, states - first));
  };
  for (std::size_t k = 0; k < n; ++k) {
    if (k > 0) {
      const double dt = samples[k].t - samples[k - 1].t;
      way.interval[k] = dt;
      x[kPushed] += 0.5 * dt * torque;
      std::array<double, Most> next{};
      for_each_part([&](int first, int count) {
        States moved = seeded(first);
        step(moved, k);
        for (int i = 0; i < states; ++i) {
          next[i] = moved[i].value;
          for (int j = 0; j < count; ++j)
            way.motion[(k * S + i) * S + first + j] = moved[i].gradient[j];
        }
      });
      x = next;
      x[kPushed] += 0.5 * dt * torque;
      torque *= gains.torque_pole;
      expected *= gains.sensor_pole;
    }
    double y = 0.0;
    for_each_part([&](int first, int count) {
      const Number shown = step.measured(seeded(first), k);
      y = shown.value;
      for (int j = 0; j < count; ++j) way.shown[k * S + first + j] = shown.gradient[j];
    });
    if (!std::isnan(samples[k].y)) {
      way.error[k] = samples[k].y - y;
      const double innovation = way.error[k] - expected;
      for (int i = 0; i < states; ++i) {
        way.correction[k * S + i] = gains(k, i) * innovation;
        x[i] += way.correction[k * S + i];
      }
      if (!gains.torque_noise.empty()) torque += gains.torque_noise[k] * innovation;
      expected = samples[k].y - value_of(step.measured(seeded(0), k));
    }
    way.torque[k] = torque;
  }
  return way;
}

template <int S>
void NoiseLikelihood::evaluate(const FilterNoise* noises, std::size_t count, double* losses) const {
  constexpr std::size_t kTidied = 8;  // samples between
  const NoisePack noise = packed(noises, count);
  double measured = 0.0;
  Pack nis{};
  Pack log_variance{};
  for (const Way& way : ways_) {
    LinearFilters<S> filters(noise, spread_, mobility_, way.samples > 1 ? way.interval[1] : 0.0);
    for (std::size_t k = 0; k < way.samples; ++k) {
      if (k > 0) filters.move(&way.motion[k * S * S], way.torque[k - 1], way.interval[k]);
      if (!std::isnan(way.error[k])) {
        filters.update(&way.shown[k * S], way.error[k], k >= way.faded);
        filters.follow(&way.correction[k * S]);
      }
      if (k % kTidied == 0) filters.tidy();
    }
    filters.tidy();
    measured += filters.count();
    nis += filters.nis();
    log_variance += filters.log_variance();
  }
  for (std::size_t lane = 0; lane < count; ++lane) {
    const int i = static_cast<int>(lane);
    const double variance = nis[i] / measured;
    const double loss =
        0.5 * (measured * (std::log(2.0 * std::numbers::pi * variance) + 1.0) + log_variance[i]);
    losses[lane] = std::isnan(loss) ? kInfinite : loss;
  }
}

std::vector<double> NoiseLikelihood::operator()(const std::vector<FilterNoise>& noises) const {
  std::vector<double> losses(noises.size());
  const std::size_t packs = (noises.size() + kPackWidth - 1) / kPackWidth;
  with_states([&]<int S>() {
    for_each_job(static_cast<int>(packs), [&](int i) {
      const std::size_t first = static_cast<std::size_t>(i) * kPackWidth;
      const std::size_t count = std::min<std::size_t>(kPackWidth, noises.size() - first);
      evaluate<S>(&noises[first], count, &losses[first]);
    });
  });
  return losses;
}

}  // namespace armukf
