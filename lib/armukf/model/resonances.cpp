#include "armukf/model/resonances.hpp"

namespace armukf {

void set_resonances(Model& model, const Resonances& resonances, double damping) {
  const auto squared = [](double v) { return v * v; };
  const double z1 = squared(resonances.zero[0]);
  const double z2 = squared(resonances.zero[1]);
  const double p1 = squared(resonances.pole[0]);
  const double p2 = squared(resonances.pole[1]);
  // torque / speed = s J (1 + x/p1)(1 + x/p2) / ((1 + x/z1)(1 + x/z2)), x = s^2
  const double J = model.parameters[kJ].value;
  const double motor = J * z1 * z2 / (p1 * p2);
  // minus s motor: s (c0 + c1 x) / (1 + q1 x + q2 x^2)
  const double c0 = J - motor;
  const double q1 = 1.0 / z1 + 1.0 / z2;
  const double q2 = 1.0 / (z1 * z2);
  const double c1 = J * (1.0 / p1 + 1.0 / p2) - motor * q1;
  // its inverse minus s / k_g: (1 + e x) / (s (c0 + c1 x))
  const double e = q1 - q2 * c0 / c1;
  const double gear = c1 / e;
  model.parameters[kAm].value = motor / J;
  model.parameters[kAg].value = gear / J;
  model.parameters[kKg1].value = c1 / q2;
  model.parameters[kKa].value = (c0 - gear) / e;
  model.parameters[kDg].value = 2.0 * damping * model.parameters[kKg1].value / resonances.pole[1];
  model.parameters[kDa].value = 2.0 * damping * model.parameters[kKa].value / resonances.pole[0];
}

}  // namespace armukf
