#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/model/arm.hpp"

/// What is true of this plant and of no other, as data that the layers above read: its masses, what
/// is measured of it, how uncertain it is before anything is known, and where else a search may
/// begin. A drive train of another shape brings its own equations and its own copy of this file.
namespace armukf {

/// The masses, in this order everywhere.
enum PlantMass { kMotor, kGear, kArm, kMassCount };

/// One of the masses: its name, the state that is its speed, and the noise that acts on it.
struct Mass {
  std::string_view name;
  int speed;
  std::string_view noise_name;  // in the model file
  double noise;                 // N.m.s^1/2, usual density, of an arm of kPublishedInertia
};

inline constexpr std::array kMasses{Mass{"motor", kSpeedMotor, "motor_torque", 0.003},
                                    Mass{"gear", kSpeedGear, "gear_torque", 0.003},
                                    Mass{"arm", kSpeedArm, "arm_torque", 0.0}};
static_assert(kMasses.size() == kMassCount);

/// The states that are the masses' speeds.
inline std::vector<int> speed_states() {
  std::vector<int> states;
  states.reserve(kMasses.size());
  for (const Mass& mass : kMasses) states.push_back(mass.speed);
  return states;
}

/// Prior standard deviations of the states at a record's first sample.
inline constexpr double kTwistSpread = 0.3;   // rad, about a spring at rest
inline constexpr double kSpeedSpread = 20.0;  // rad/s, of a mass against the measured one, which is
                                              // what an arm that oscillates already may have

/// The state that the sensor shows, and of the masses the one that the input drives.
inline constexpr int kMeasuredState = kSpeedMotor;
inline constexpr int kDrivenMass = kMotor;

/// The unknowns of the published study, last in the order of the parameters: the size of a belief
/// that is known while compiling.
inline constexpr int kPublishedUnknowns = kArmParameters - kAm;

/// 1/(kg.m^2), inverse inertia of each mass; p: a value per parameter.
inline std::array<double, kMassCount> mobilities(const double* p) {
  const Coefficients<double> c(p);
  return {c.motor_mobility, c.gear_mobility, c.arm_mobility};
}

/// kg.m^2, J of the published arm.
inline constexpr double kPublishedInertia = 0.03291699877416;

/// How heavy an arm of that inertia (kg.m^2) is beside the published one. What is usual of torques,
/// of noises, friction and springs among them, is so many times as much.
constexpr double heaviness(double inertia) { return inertia / kPublishedInertia; }

/// 1/(kg.m^2), by which a torque that is usual of the published arm accelerates each mass of
/// another, of which as much more is usual as it is heavier: what the masses' shares tell alone.
inline std::array<double, kMassCount> usual_mobilities(const double* p) {
  std::array<double, kMassCount> all = mobilities(p);
  for (double& mobility : all) mobility *= heaviness(p[kJ]);
  return all;
}

/// Factors on start values, by the parameters' names.
using StartFactors = std::map<std::string, double>;

/// Where a filter may begin beside the values as given. The worst wrong turn is an arm spring so
/// stiff or so damped that gear box and arm are one mass: there the record no longer pulls the
/// parameters back. Hence two starts from the soft, lightly damped side.
inline std::vector<StartFactors> filter_starts() {
  return {{},
          {{"k_a", 0.5}, {"d_g", 0.5}, {"d_a", 0.5}},
          {{"k_g3", 2.5}, {"k_a", 0.6}, {"d_g", 0.5}, {"d_a", 0.5}}};
}

/// The same for a batch fit: a soft and lightly damped arm.
inline StartFactors soft_start() { return {{"d_g", 0.5}, {"k_a", 0.5}, {"d_a", 0.5}}; }

/// rad; no joint of such a machine is wound further when a record begins, and none survives the
/// second.
inline constexpr double kUsualTwist = 1.0;
inline constexpr double kMostTwist = 10.0;

/// The springs that hold the masses together. A search that knows nothing of an arm leaves them
/// this much of their given and of their typical stiffness at least: a mass that is let go floats
/// about and mimics a drifting torque, and from there nothing leads back.
inline constexpr std::array kSprings{kKg1, kKa};
inline constexpr double kLeastSpring = 1.0 / 30;

/// rad/s; no motor turns so fast: a simulation that says so has diverged.
inline constexpr double kRunawaySpeed = 1e6;

/// What a record of slow motion tells, in which the arm moves as one mass: friction, and then the
/// total inertia.
inline constexpr std::array kFrictionParameters{kFv, kFc, kFcs, kAlpha, kBeta};
inline constexpr int kTotalInertia = kJ;

/// What a frequency response tells, and the hardening that it does not.
inline constexpr std::array kResonantParameters{kAm, kAg, kKg1, kKa, kDg, kDa};
inline constexpr int kHardening = kKg3;
inline constexpr int kHardenedStiffness = kKg1;

}  // namespace armukf
