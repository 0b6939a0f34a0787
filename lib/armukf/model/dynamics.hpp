#pragma once

#include <array>
#include <memory>
#include <tuple>
#include <utility>

#include "armukf/core/dual.hpp"
#include "armukf/core/lanes.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// A row per state (or parameter), each of numbers T.
template <class T, int N>
using Rows = std::array<T, N>;

/// The rows that a model uses of a state that may have room for more: known while compiling where
/// there is room for the arm alone.
template <class State>
auto rows_in_use(const Model& model) {
  if constexpr (std::tuple_size_v<State> == kArmStates) {
    return std::integral_constant<int, kArmStates>();
  } else {
    return static_cast<int>(model.states.size());
  }
}

/// dx/dt of a whole model, arm and effects, with all that does not change during a step worked out
/// once. T is double (runs it), Dual (differentiates it) or Pack (several points at once).
template <class T>
class Dynamics {
 public:
  Dynamics() = default;

  /// p: a value per parameter of the model, in its order; both must outlive this.
  Dynamics(const Model& model, const T* p)
      : effects_(&model.effects), parameters_(p), coefficients_(p) {}

  /// t in s since the first sample; u in N.m; x and dx hold a value per state of the model.
  void derivative(const Time<T>& t, const T& u, const T* x, T* dx) const {
    arm_derivative(u, x, dx);
    if (!effects_->empty()) add_effects(t, u, x, dx);
  }

  /// The same of the arm alone.
  void arm_derivative(const T& u, const T* x, T* dx) const {
    armukf::derivative(coefficients_, x, u, dx);
  }

  /// rad/s, what the sensor shows of the motor's speed.
  T measured(const Time<T>& t, const T& u, const T* x) const {
    return x[kSpeedMotor] + sensed(t, u, x);
  }

  /// rad/s, what it shows beside that speed.
  T sensed(const Time<T>& t, const T& u, const T* x) const {
    T y{};
    const Motion<T> motion{since_first_sample(t), u, x, coefficients_};
    for (const EffectSlot& slot : *effects_) {
      std::visit(
          [&]<class E>(const E&) {
            if constexpr (ActsOnSensor<E>)
              y += E::sensed(motion, x + slot.first_state, parameters_ + slot.first_parameter);
          },
          slot.effect);
    }
    return y;
  }

 private:
  /// What the effects do to the masses, into dx; and the rates of their states. Not inlined: it
  /// would push the arm's numbers out of the registers.
  [[gnu::noinline]] void add_effects(const Time<T>& t, const T& u, const T* x, T* dx) const {
    T reaching = u;  // of the command, the next part of the drive
    T given = u;     // by the parts so far
    const Motion<T> motion{since_first_sample(t), reaching, x, coefficients_};
    Loads<T> loads(coefficients_, dx);
    for (const EffectSlot& slot : *effects_) {
      std::visit(
          [&]<class E>(const E&) {
            const T* own = x + slot.first_state;
            const T* p = parameters_ + slot.first_parameter;
            if constexpr (LatePartOfDrive<E>) reaching = given;
            if constexpr (ActsOnMasses<E>) {
              const auto action = E::contribute(motion, own, p);
              action.act(loads);
              if constexpr (PartOfDrive<E>) given = given + action.torque;
            }
            if constexpr (!E::states.empty()) E::rates(motion, own, p, dx + slot.first_state);
            if constexpr (LatePartOfDrive<E>) reaching = given;
          },
          slot.effect);
    }
    loads.share_out();
  }

  const std::vector<EffectSlot>* effects_ = nullptr;
  const T* parameters_ = nullptr;
  Coefficients<T> coefficients_;
};

/// The model as a system of equations that an Odeint stepper moves: f(x, dx, t) over N rows of
/// numbers T, of which the model's states are the first; the parameters are those of the free
/// coordinates z. The input u (N.m) is held.
template <class T, int N>
class System {
 public:
  System(const Model& model, const FreeCoordinates& coordinates, const T* z, double u) : u_(u) {
    coordinates.to_physical(z, parameters_.data());
    std::construct_at(&dynamics_, model, parameters_.data());
  }
  System(const System&) = delete;  // the dynamics point into this
  System& operator=(const System&) = delete;

  void operator()(const Rows<T, N>& x, Rows<T, N>& dx, double t) const {
    dynamics_.derivative(t, u_, x.data(), dx.data());
  }

 private:
  T u_;
  std::array<T, kMaxParameters> parameters_;
  Dynamics<T> dynamics_;
};

/// The same for rows of lanes, one pack of lanes after the other.
template <int L, int N>
class System<Lanes<L>, N> {
 public:
  System(const Model& model, const FreeCoordinates& coordinates, const Lanes<L>* z, double u)
      : u_(broadcast(u)), rows_(rows_in_use<Rows<Pack, N>>(model)) {
    std::array<Lanes<L>, kMaxParameters> physical;
    coordinates.to_physical(z, physical.data());
    const int count = static_cast<int>(model.parameters.size());
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < kPacks; ++k) parameters_[k][i] = physical[i].packs[k];
    for (int k = 0; k < kPacks; ++k) std::construct_at(&dynamics_[k], model, parameters_[k].data());
  }
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  void operator()(const Rows<Lanes<L>, N>& x, Rows<Lanes<L>, N>& dx, double t) const {
    for (int k = 0; k < kPacks; ++k) {
      std::array<Pack, N> point;
      std::array<Pack, N> rate;

      for (int i = 0; i < rows_; ++i) point[i] = x[i].packs[k];
      dynamics_[k].derivative(broadcast(t), u_, point.data(), rate.data());
      for (int i = 0; i < rows_; ++i) dx[i].packs[k] = rate[i];
    }
  }

 private:
  static constexpr int kPacks = Lanes<L>::kPacks;
  Pack u_;
  [[no_unique_address]] decltype(rows_in_use<Rows<Pack, N>>(std::declval<Model>())) rows_;
  std::array<std::array<Pack, kMaxParameters>, kPacks> parameters_;
  std::array<Dynamics<Pack>, kPacks> dynamics_;
};

}  // namespace armukf
