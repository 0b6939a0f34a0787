#include "world.hpp"

#include <limits>

#include "draw.hpp"

namespace blind {
namespace {

/// Every physical value within 30 % of the published one; J is the sum of the three drawn inertias.
ArmValues drawn_arm(Draw draw) {
  ArmValues p;
  const auto varied = [&draw](double value) { return value * draw.between(0.7, 1.3); };
  const double motor = varied(p.J * p.a_m);
  const double gear = varied(p.J * p.a_g);
  const double arm = varied(p.J * (1.0 - p.a_m - p.a_g));
  p.J = motor + gear + arm;
  p.a_m = motor / p.J;
  p.a_g = gear / p.J;
  for (double* value :
       {&p.Fv, &p.Fc, &p.Fcs, &p.alpha, &p.beta, &p.k_g1, &p.k_g3, &p.d_g, &p.k_a, &p.d_a})
    *value = varied(*value);
  return p;
}

/// Low-pass fast enough for the loop around the motor's own inertia to keep a phase margin of 45
/// degrees and more, as whoever tunes a drive would see to.
Controller drawn_controller(const ArmValues& arm, Draw draw) {
  Controller c{};
  c.proportional = draw.log_between(1.5, 6.0);
  c.integral_time = draw.chance(2.0 / 3.0) ? draw.log_between(0.03, 0.3)
                                           : std::numeric_limits<double>::infinity();
  c.filter_time = draw.between(0.0, 0.5) * arm.J * arm.a_m / c.proportional;
  return c;
}

Motion drawn_motion(Draw& draw) {
  return static_cast<Motion>(static_cast<std::uint8_t>(draw.between(0.0, 3.0)));
}

}  // namespace

World drawn_world(std::uint64_t seed) {
  const ArmValues arm = drawn_arm(Draw(seed, 1));
  Draw noise(seed, 2);
  const ColouredNoise sensor{noise.log_between(0.05, 0.5), noise.about(0.0, 0.5, 0.8)};
  const ColouredNoise torque{noise.log_between(0.05, 0.3), 0.9};
  Draw motion(seed, 4);
  const Motion usual = drawn_motion(motion);
  return {
      seed, arm, sensor, torque, drawn_controller(arm, Draw(seed, 3)), usual, drawn_motion(motion),
      seed};
}

}  // namespace blind
