#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/core/lanes.hpp"
#include "armukf/filter/noise_spectrum.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/model.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/ode/propagate.hpp"
#include "armukf/online/condition.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// States of a predictor beside those of the model: the noise of the torque and that of the sensor.
inline constexpr int kPredictorNoises = 2;

/// The noises that a predictor reckons with, per usual sample: coloured ones of the driven mass's
/// torque and of the sensor.
struct PredictorNoise {
  ColouredNoise torque;  // N.m
  ColouredNoise sensor;  // rad/s

  template <class Archive>
  void archive(Archive& archive) {
    archive(torque, sensor);
  }
};

/// Leaves out single measurements that cannot be; several in a row are a change, not outliers.
struct OutlierGate {
  double deviations = 6.0;
  int patience = 3;  // samples

  double width(int astray) const { return astray < patience ? deviations : kInfinite; }
  /// Whether an innovation (in deviations) was left out; counts those in a row.
  bool shuts_out(double innovation, int& astray) const {
    if (std::abs(innovation) <= deviations) {
      astray = 0;
      return false;
    }
    return astray++ < patience;
  }
};

/// A Kalman filter of the arm's states and of the two noises, its parameters frozen; and beside it
/// the same filter, with the same gains, for machines in other conditions. What its innovation has
/// above theirs is what their condition would add to its innovations. All of them are lanes of one
/// motion; lanes that differ in one state give the filter's transition. N: most states of the
/// model.
template <int N>
class PredictorBank {
 public:
  PredictorBank(const Model& model, const Propagation& propagation)
      : model_(&model), propagation_(propagation), states_(static_cast<int>(model.states.size())) {}

  static constexpr int kStride = padded(N + kPredictorNoises, 4);
  using Square = std::array<std::array<double, kStride>, N + kPredictorNoises>;

  /// What the first filter believes.
  struct Belief {
    std::array<double, N + kPredictorNoises> mean{};
    Square covariance{};

    template <class Archive>
    void archive(Archive& archive) {
      archive(mean, covariance);
    }
  };
  const Belief& belief() const { return belief_; }

  /// Makes room for so many conditions.
  void reserve(std::size_t conditions) {
    machines_.resize(std::max<std::size_t>(machines_.size(), packs_of(conditions)));
    innovations_.resize(machines_.size());
  }

  /// Goes on with these conditions, of which the first is the filter's own, all of them where that
  /// one is. `sample_s` (s) is the usual interval. Allocates where there are more than ever.
  void freeze(std::span<const Condition> conditions, const PredictorNoise& noise, double sample_s) {
    sample_s_ = sample_s;
    noise_ = noise;
    kick_ = sample_s * mobilities(conditions[0].parameters.data())[kDrivenMass];
    count_ = static_cast<int>(conditions.size());
    pack_count_ = packs_of(conditions.size());
    reserve(conditions.size());
    for (int lane = 0; lane < pack_count_ * kPackWidth; ++lane) {
      const int k = lane - states();
      set(lane, k > 0 && k < count_ ? conditions[k] : conditions[0]);
    }
    for (int i = 0; i < pack_count_; ++i)
      std::construct_at(&machines_[i].dynamics, *model_, machines_[i].parameters.data());
    believe(belief_);
  }

  /// All filters believe this.
  void believe(const Belief& belief) {
    belief_ = belief;
    for (int lane = 0; lane < pack_count_ * kPackWidth; ++lane) place(lane, belief_.mean);
  }

  /// That the states are these (the model's), with these deviations, or with large ones where there
  /// are none; the noises anything.
  Belief starting(std::span<const double> x, std::span<const double> sd = {}) const {
    Belief belief;
    std::copy_n(x.begin(), states(), belief.mean.begin());
    for (int i = 0; i < states(); ++i) {
      const double of_state = sd.empty() ? kStartSd : sd[i];
      belief.covariance[i][i] = of_state * of_state;
    }
    belief.covariance[torque_row()][torque_row()] = noise_.torque.sd * noise_.torque.sd;
    belief.covariance[sensor_row()][sensor_row()] = noise_.sensor.sd * noise_.sensor.sd;
    return belief;
  }
  /// All filters start with that.
  void start(std::span<const double> x, std::span<const double> sd = {}) {
    believe(starting(x, sd));
  }

  /// Moves all over dt (s) from t (s since the first sample) under the torques u that were
  /// commanded.
  void predict(double t, double dt, const TorqueMemory& u) {
    spread_states();
    for (int i = 0; i < pack_count_; ++i) move(machines_[i], t, dt, u);
    move_covariance();
    for (int i = 0; i < size(); ++i) belief_.mean[i] = lane(0, i);
  }

  /// Takes a measurement y (rad/s) at t (s). Returns the innovation in standard deviations: white
  /// where the first condition holds. One beyond `gate` moves nothing.
  double update(double t, double y, double gate) {
    std::array<double, N + kPredictorNoises> PH;
    auto& P = belief_.covariance;
    const int n = size();
    const double gain = 1.0 + machines_[0].sensor_gain[0];
    for (int i = 0; i < n; ++i) PH[i] = gain * P[i][kMeasuredState] + P[i][sensor_row()];
    const double S = gain * PH[kMeasuredState] + PH[sensor_row()] +
                     kWhitePart * noise_.sensor.sd * noise_.sensor.sd;
    const double inverse = 1.0 / S;
    scale_ = std::sqrt(inverse);
    for (int p = 0; p < pack_count_; ++p) innovations_[p] = y - shown(machines_[p], t);
    const double e = innovations_[0][0] * scale_;
    if (std::abs(e) > gate) return e;
    for (int i = 0; i < n; ++i) {
      const double K = PH[i] * inverse;
      for (int p = 0; p < pack_count_; ++p) machines_[p].x[i].packs[0] += K * innovations_[p];
      for (int j = 0; j < n; ++j) P[i][j] -= K * PH[j];
      belief_.mean[i] = machines_[0].x[i].packs[0][0];
    }
    return e;
  }

  /// Puts the filter in condition k to where the first one is.
  void join(int k) { place(states() + k, belief_.mean); }

  /// Where all filters are; they were frozen alike before.
  template <class Archive>
  void archive(Archive& archive) {
    archive(belief_, scale_);
    for (int lane = 0; lane < states() + count_; ++lane)
      for (int i = 0; i < size(); ++i) {
        double x = this->lane(lane, i);
        archive(x);
        machines_[lane / kPackWidth].x[i][lane % kPackWidth] = x;
      }
  }

  /// The same innovation of the filter in condition k, in deviations of the first one.
  double innovation(int k) const {
    const int lane = k == 0 ? 0 : states() + k;
    return scale_ * innovations_[lane / kPackWidth][lane % kPackWidth];
  }

 private:
  static constexpr double kNudge = 1e-4;      // rad and rad/s, for the transition
  static constexpr double kStartSd = 0.3;     // rad, rad/s
  static constexpr double kWhitePart = 1e-4;  // of the sensor's variance: keeps S regular

  /// As many machines as a register has lanes.
  struct Machine {
    std::array<Lanes<kPackWidth>, N + kPredictorNoises> x{};
    std::array<Pack, kMaxParameters> parameters{};
    Dynamics<Pack> dynamics;
    Pack torque_gain{};
    Pack torque_bias{};
    Pack delay{};  // samples
    Pack sensor_gain{};
    Pack sensor_bias{};
    Pack u{};
  };

  /// The motion of a register's machines as a stepper wants it.
  struct Motion {
    const Machine& m;
    void operator()(const std::array<Lanes<kPackWidth>, N>& x, std::array<Lanes<kPackWidth>, N>& dx,
                    double t) const {
      std::array<Pack, N> point;
      std::array<Pack, N> rate{};
      for (int i = 0; i < N; ++i) point[i] = x[i].packs[0];
      m.dynamics.derivative(broadcast(t), m.u, point.data(), rate.data());
      for (int i = 0; i < N; ++i) dx[i].packs[0] = rate[i];
    }
  };

  /// Of the bare arm they are known while compiling.
  int states() const { return N == kArmStates ? N : states_; }
  int packs_of(std::size_t conditions) const {
    return padded(states() + static_cast<int>(conditions), kPackWidth) / kPackWidth;
  }
  int size() const { return states() + kPredictorNoises; }
  int torque_row() const { return states(); }
  int sensor_row() const { return states() + 1; }

  void set(int lane, const Condition& c) {
    Machine& m = machines_[lane / kPackWidth];
    const int i = lane % kPackWidth;
    for (std::size_t k = 0; k < model_->parameters.size(); ++k)
      m.parameters[k][i] = c.parameters[k];
    m.torque_gain[i] = c.torque_gain;
    m.torque_bias[i] = c.torque_bias;
    m.delay[i] = c.input_delay / sample_s_;
    m.sensor_gain[i] = c.sensor_gain;
    m.sensor_bias[i] = c.sensor_bias;
  }

  void place(int lane, const std::array<double, N + kPredictorNoises>& x) {
    for (int i = 0; i < size(); ++i) machines_[lane / kPackWidth].x[i][lane % kPackWidth] = x[i];
  }

  /// The lanes of the transition: at the reference, each with one state moved.
  void spread_states() {
    for (int i = 0; i < states(); ++i) {
      place(1 + i, belief_.mean);
      machines_[(1 + i) / kPackWidth].x[i][(1 + i) % kPackWidth] += kNudge;
    }
  }
  Pack shown(const Machine& m, double t) const {
    std::array<Pack, N + kPredictorNoises> x;
    for (int i = 0; i < size(); ++i) x[i] = m.x[i].packs[0];
    return (1.0 + m.sensor_gain) * m.dynamics.measured(broadcast(t), m.u, x.data()) +
           x[sensor_row()] + m.sensor_bias;
  }

  void move(Machine& m, double t, double dt, const TorqueMemory& u) {
    Pack commanded{};
    for (int i = 0; i < kPackWidth; ++i) commanded[i] = u.before(m.delay[i]);
    m.u = (1.0 + m.torque_gain) * commanded + m.torque_bias;
    std::array<Lanes<kPackWidth>, N> x;
    for (int i = 0; i < N; ++i) x[i] = m.x[i];
    constexpr int kDriven = kMasses[kDrivenMass].speed;
    const Pack half_kick = 0.5 * kick_ * m.x[torque_row()].packs[0];
    x[kDriven].packs[0] += half_kick;
    propagate(propagation_, Motion{m}, x, t, dt);
    x[kDriven].packs[0] += half_kick;
    for (int i = 0; i < states(); ++i) m.x[i] = x[i];
    m.x[torque_row()].packs[0] *= noise_.torque.pole;
    m.x[sensor_row()].packs[0] *= noise_.sensor.pole;
  }

  double lane(int lane, int row) const {
    return machines_[lane / kPackWidth].x[row][lane % kPackWidth];
  }

  /// P -> F P F' + Q.
  void move_covariance() {
    auto& P = belief_.covariance;
    const int n = size();
    constexpr int kDriven = kMasses[kDrivenMass].speed;
    Square transposed{};  // of the transition F
    for (int j = 0; j < states(); ++j)
      for (int i = 0; i < states(); ++i)
        transposed[j][i] = (lane(1 + j, i) - lane(0, i)) * (1.0 / kNudge);
    for (int i = 0; i < states(); ++i)
      transposed[torque_row()][i] =
          0.5 * kick_ * (transposed[kDriven][i] + (i == kDriven ? 1.0 : 0.0));
    transposed[torque_row()][torque_row()] = noise_.torque.pole;
    transposed[sensor_row()][sensor_row()] = noise_.sensor.pole;
    // P F', and of that, which is (F P)', again the product with F'.
    const Square PF = product(P, transposed);
    Square FP{};
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) FP[i][j] = PF[j][i];
    P = product(FP, transposed);
    // Rounding would make the halves part, and grow.
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j) P[j][i] = P[i][j];
    for (int i = 0; i < states(); ++i) P[i][i] += kLeastNoise;
    P[torque_row()][torque_row()] += noise_.torque.driving_variance();
    P[sensor_row()][sensor_row()] += noise_.sensor.driving_variance();
  }

  static Square product(const Square& a, const Square& b) {
    Square sum{};
    for (int i = 0; i < N + kPredictorNoises; ++i)
      for (int k = 0; k < N + kPredictorNoises; ++k)
        for (int j = 0; j < kStride; ++j) sum[i][j] += a[i][k] * b[k][j];
    return sum;
  }

  static constexpr double kLeastNoise = 1e-16;  // rad^2, (rad/s)^2

  const Model* model_;
  Propagation propagation_;
  int states_;
  int count_ = 0;  // of conditions
  int pack_count_ = 0;
  double sample_s_ = 5e-4;
  double kick_ = 0.0;   // (rad/s)/(N.m)
  double scale_ = 0.0;  // s/rad, one over the innovation's deviation
  PredictorNoise noise_;
  std::vector<Machine> machines_;  // the first filter, those of the transition, the others
  std::vector<Pack> innovations_;
  Belief belief_;
};

}  // namespace armukf
