#include "armukf/model/fastest_rate.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/core/dual.hpp"
#include "armukf/model/dynamics.hpp"

namespace armukf {

double fastest_rate(const Model& model) {
  using Number = Dual<kMaxStates>;
  const bool faster = std::ranges::any_of(
      model.effects, [](const EffectSlot& slot) { return is_fast_in_motion(slot.effect); });
  if (faster) return kInfinite;
  const std::vector<double> values = model.values();
  const std::vector<Number> parameters(values.begin(), values.end());
  const auto count = static_cast<Eigen::Index>(model.states.size());
  std::array<Number, kMaxStates> x{};
  std::array<Number, kMaxStates> rate{};
  for (Eigen::Index i = 0; i < count; ++i) x[i] = Number::variable(0.0, static_cast<int>(i));
  Dynamics<Number>(model, parameters.data()).derivative(0.0, Number(0.0), x.data(), rate.data());
  Eigen::MatrixXd motion(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j) motion(i, j) = rate[i].gradient[static_cast<int>(j)];
  if (!motion.allFinite()) return kInfinite;
  return motion.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace armukf
