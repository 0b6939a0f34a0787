#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "armukf/core/dual.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// Free coordinates z, any real number, of the unknown parameters: whatever z is, the parameters
/// are inside their bounds, so that no sigma point and no search step is ever unphysical.
///
///     share      a_m, a_g       a_i = T e^{z_i} / (1 + sum_j e^{z_j}), T = 1 - the known shares:
///                               z_i = ln(a_i / a_a), a_a the arm's share
///     log        [l, inf)       l + e^z
///     scaled     any other      s z, s the parameter's scale; beyond a bound: the bound
///
/// A share has no other bounds here than 0 and what the others leave. A coordinate that moves by 1
/// moves its parameter by one size: by a factor of e or, where it is scaled, by the scale. Of the
/// size of an effect nothing is a likely value, which no logarithm reaches: it would walk off, ever
/// surer of ever less.
class FreeCoordinates {
 public:
  explicit FreeCoordinates(const Model& model);

  int size() const { return static_cast<int>(unknowns_.size()); }

  /// Positions of the unknown parameters in the model, in the order of z.
  const std::vector<int>& unknowns() const { return unknowns_; }

  /// All parameters p of the model (known ones as they are) from the free coordinates z.
  template <class T>
  void to_physical(const T* z, T* p) const;

  /// The free coordinates of given parameter values (one per parameter of the model). A value on
  /// its bound, which is none that was found, is first moved inside by the parameter's scale.
  std::vector<double> from_physical(const std::vector<double>& p) const;
  /// The same into z, which has room for them: nothing is allocated.
  void from_physical(const std::vector<double>& p, double* z) const;

  /// Whether the coordinate at that position is its parameter over the scale, no logarithm.
  bool is_scaled(int position) const { return kinds_[position] == Kind::kScaled; }

  /// Moves what lies beyond a bound to just inside it: a filter's mean that reckons with what is
  /// beyond would be slow to come back.
  void keep_inside(double* z) const;

  /// Known parameters have these values from now on (one per parameter of the model).
  void take_known(const std::vector<double>& p);

  /// Standard deviations of the unknowns' physical values (first order), in the order of z, from
  /// their physical values p (one per parameter of the model) and cov(z_i, z_j) = covariance(i, j).
  template <class Covariance>
  void deviations(const double* p, const Covariance& covariance, double* sd) const;

  /// Covariance of the physical values of the i-th and j-th unknown (first order), from the same.
  template <class Covariance>
  double physical_covariance(int i, int j, const double* p, const Covariance& covariance) const {
    return carried(i, j, covariance, [&](int k, int l) { return gradient(k, l, p); });
  }

  /// The same the other way: cov(z_i, z_j) from the covariance of the physical values.
  template <class Covariance>
  double free_covariance(int i, int j, const double* p, const Covariance& covariance) const {
    return carried(i, j, covariance, [&](int k, int l) { return inverse_gradient(k, l, p); });
  }

 private:
  enum class Kind { kShare, kLog, kScaled };
  Kind kind_of(int parameter) const;
  double slope(int position, double value) const;  // dp/dz, for all but shares
  /// d p_k / d z_j of the unknowns k and j.
  double gradient(int k, int j, const double* p) const;
  double inverse_gradient(int k, int j, const double* p) const;  // d z_k / d p_j

  /// (G C G')_ij of a covariance C and a gradient G.
  template <class Covariance, class Gradient>
  double carried(int i, int j, const Covariance& covariance, const Gradient& gradient) const {
    double sum = 0.0;
    for (int a = 0; a < size(); ++a) {
      const double along = gradient(i, a);
      if (along == 0.0) continue;
      for (int b = 0; b < size(); ++b) sum += along * gradient(j, b) * covariance(a, b);
    }
    return sum;
  }

  std::vector<Parameter> parameters_;
  std::vector<int> unknowns_;
  std::vector<int> knowns_;
  std::vector<Kind> kinds_;
  double free_share_ = 1.0;  // what the known shares leave
};

template <class T>
void FreeCoordinates::to_physical(const T* z, T* p) const {
  std::array<T, kMaxParameters> e;
  exponentials(z, e.data(), size());
  for (const int i : knowns_) p[i] = T() + parameters_[i].value;
  T shares = T() + 1.0;
  for (int k = 0; k < size(); ++k) {
    const Parameter& parameter = parameters_[unknowns_[k]];
    T& value = p[unknowns_[k]];
    switch (kinds_[k]) {
      case Kind::kShare:
        value = e[k];
        shares += e[k];
        break;
      case Kind::kLog:
        value = parameter.lower + e[k];
        break;
      case Kind::kScaled:
        value = between(T(parameter.scale * z[k]), parameter.lower, parameter.upper);
        break;
    }
  }
  const T unit = free_share_ / shares;
  for (int k = 0; k < size(); ++k)
    if (kinds_[k] == Kind::kShare) p[unknowns_[k]] = p[unknowns_[k]] * unit;
}

template <class Covariance>
void FreeCoordinates::deviations(const double* p, const Covariance& covariance, double* sd) const {
  for (int k = 0; k < size(); ++k) {
    const double value = p[unknowns_[k]];
    if (kinds_[k] != Kind::kShare) {
      sd[k] = std::sqrt(covariance(k, k)) * slope(k, value);
      continue;
    }
    // da_k/dz_j = a_k (delta_kj - a_j / T)
    double variance = 0.0;
    const auto relative = [&](int j) { return (j == k) - p[unknowns_[j]] / free_share_; };
    for (int i = 0; i < size(); ++i)
      for (int j = 0; j < size(); ++j)
        if (kinds_[i] == Kind::kShare && kinds_[j] == Kind::kShare)
          variance += relative(i) * relative(j) * covariance(i, j);
    sd[k] = value * std::sqrt(variance);
  }
}

}  // namespace armukf
