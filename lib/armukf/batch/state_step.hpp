#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagate.hpp"

namespace armukf {

/// A model's states from sample k - 1 to sample k of a record, for rows of any number T. All that
/// it is made of must outlive it.
template <class T>
class StateStep {
 public:
  StateStep(const Model& model, const std::vector<Sample>& samples, const Propagation& propagation)
      : model_(model),
        samples_(samples),
        propagation_(propagation),
        begin_(propagation.begin(samples[0].t)),
        p_(to_numbers(model)),
        dynamics_(model, p_.data()) {}
  StateStep(const StateStep&) = delete;  // the dynamics point into this
  StateStep& operator=(const StateStep&) = delete;

  template <class State>
  void operator()(State& x, std::size_t k) const {
    const Sample& last = samples_[k - 1];
    const auto f = [&, u = T(last.u)](const auto& state, auto& rate, double t) {
      dynamics_.derivative(t, u, state.data(), rate.data());
    };
    propagate(propagation_, f, x, last.t - begin_, samples_[k].t - last.t,
              rows_in_use<State>(model_));
  }

  /// rad/s, what the sensor shows of these states at sample k.
  template <class State>
  T measured(const State& x, std::size_t k) const {
    const Sample& sample = samples_[k];
    return dynamics_.measured(sample.t - begin_, T(sample.u), x.data());
  }

 private:
  static std::vector<T> to_numbers(const Model& model) {
    const std::vector<double> values = model.values();
    return {values.begin(), values.end()};
  }

  const Model& model_;
  const std::vector<Sample>& samples_;
  const Propagation& propagation_;
  double begin_;  // s, of effects
  std::vector<T> p_;
  Dynamics<T> dynamics_;
};

}  // namespace armukf
