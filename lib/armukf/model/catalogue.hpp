#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "armukf/model/effects/angle_curve.hpp"
#include "armukf/model/effects/arm_backlash.hpp"
#include "armukf/model/effects/arm_friction.hpp"
#include "armukf/model/effects/arm_hysteresis.hpp"
#include "armukf/model/effects/arm_spring_curve.hpp"
#include "armukf/model/effects/arm_stiffness_cubic.hpp"
#include "armukf/model/effects/backlash.hpp"
#include "armukf/model/effects/coulomb_asymmetry.hpp"
#include "armukf/model/effects/drive_lag.hpp"
#include "armukf/model/effects/drive_lag_second_order.hpp"
#include "armukf/model/effects/drive_notch.hpp"
#include "armukf/model/effects/external_torque.hpp"
#include "armukf/model/effects/flexible_mode.hpp"
#include "armukf/model/effects/friction_change.hpp"
#include "armukf/model/effects/friction_curve.hpp"
#include "armukf/model/effects/friction_lag.hpp"
#include "armukf/model/effects/friction_parameters.hpp"
#include "armukf/model/effects/friction_ripple.hpp"
#include "armukf/model/effects/gear_damping_quadratic.hpp"
#include "armukf/model/effects/gear_friction.hpp"
#include "armukf/model/effects/gear_hysteresis.hpp"
#include "armukf/model/effects/gear_relaxation.hpp"
#include "armukf/model/effects/gear_slip.hpp"
#include "armukf/model/effects/gear_spring_curve.hpp"
#include "armukf/model/effects/gear_stiffness_ripple.hpp"
#include "armukf/model/effects/gravity.hpp"
#include "armukf/model/effects/input_delay.hpp"
#include "armukf/model/effects/load_dependent_friction.hpp"
#include "armukf/model/effects/payload_change.hpp"
#include "armukf/model/effects/pose_inertia.hpp"
#include "armukf/model/effects/presliding_friction.hpp"
#include "armukf/model/effects/presliding_friction_lugre.hpp"
#include "armukf/model/effects/sensor_coupling.hpp"
#include "armukf/model/effects/sensor_curve.hpp"
#include "armukf/model/effects/sensor_gain.hpp"
#include "armukf/model/effects/sensor_lag.hpp"
#include "armukf/model/effects/speed_ripple.hpp"
#include "armukf/model/effects/speed_ripple_constant.hpp"
#include "armukf/model/effects/stiffness_change.hpp"
#include "armukf/model/effects/thermal_damping.hpp"
#include "armukf/model/effects/thermal_friction.hpp"
#include "armukf/model/effects/thermal_friction_cold.hpp"
#include "armukf/model/effects/thermal_friction_heated.hpp"
#include "armukf/model/effects/thermal_torque.hpp"
#include "armukf/model/effects/thermal_torque_heated.hpp"
#include "armukf/model/effects/torque_bias.hpp"
#include "armukf/model/effects/torque_curve.hpp"
#include "armukf/model/effects/torque_gain.hpp"
#include "armukf/model/effects/torque_limit.hpp"
#include "armukf/model/effects/torque_ripple.hpp"
#include "armukf/model/effects/torque_ripple_commanded.hpp"
#include "armukf/model/effects/torque_slew.hpp"
#include "armukf/model/effects/transmission_error.hpp"

namespace armukf {

/// Every effect that a model may have. A new one is a header in effects/ and one line here.
using CataloguedEffect = std::variant<
    effects::TorqueBias, effects::TorqueGain, effects::TorqueRipple, effects::InputDelay,
    effects::DriveLag, effects::DriveLagSecondOrder, effects::FrictionParameters,
    effects::CoulombAsymmetry, effects::GearFriction, effects::ArmFriction,
    effects::LoadDependentFriction, effects::ThermalFriction, effects::ThermalFrictionHeated,
    effects::ThermalFrictionCold, effects::PreslidingFriction, effects::PreslidingFrictionLugre,
    effects::Backlash, effects::GearHysteresis, effects::GearDampingQuadratic,
    effects::ArmStiffnessCubic, effects::FlexibleMode<kArm>, effects::FlexibleMode<kGear>,
    effects::FlexibleMode<kMotor>, effects::Gravity, effects::PayloadChange, effects::SensorLag,
    effects::SpeedRipple, effects::SpeedRippleConstant, effects::ExternalTorque<kMotor>,
    effects::ExternalTorque<kArm>, effects::FrictionChange, effects::FrictionRipple,
    effects::TorqueRippleCommanded, effects::ThermalTorque, effects::ThermalTorqueHeated,
    effects::ThermalDamping, effects::GearStiffnessRipple, effects::TransmissionError,
    effects::PoseInertia, effects::ArmBacklash, effects::ArmHysteresis, effects::SensorCoupling,
    effects::GearStiffnessChange, effects::ArmStiffnessChange, effects::GearSlip,
    effects::GearRelaxation, effects::TorqueLimit, effects::TorqueSlew, effects::FrictionLag,
    effects::DriveNotch, effects::SensorGain, effects::FrictionCurve, effects::GearSpringCurve,
    effects::ArmSpringCurve, effects::TorqueCurve, effects::AngleCurve, effects::SensorCurve>;

/// An effect as the user names it: `torque_ripple`, or `torque_ripple:2` for the second of its
/// kind.
struct EffectName {
  std::string kind;  // its name in the catalogue
  int number = 1;
};

/// Takes such a name apart; InputError where the number is none.
EffectName parse_effect_name(std::string_view name);

/// The effect of that kind; throws InputError that lists the known names. `flexible_mode` without a
/// site is the one at the arm.
CataloguedEffect find_effect(std::string_view kind);

/// Its name in the catalogue.
std::string_view name_of(const CataloguedEffect& effect);

/// The names in the catalogue, in its order.
std::vector<std::string_view> effect_names();

/// What an effect and its relatives at other sites, or by another law of the same cause, are called
/// together: `flexible_mode` for `flexible_mode_gear:2`, its own kind for any other.
std::string family_of(std::string_view effect);

/// Whether it is a curve that is learnt, which a search for names leaves out.
bool is_learnt_law(const CataloguedEffect& effect);

/// Whether a model may have several of it: at other harmonics or frequencies, or moments.
bool may_be_several(const CataloguedEffect& effect);

/// Whether the sensor shows what moves through states of the effect's own: then it gives the noise
/// of the torque another colour.
bool colours_noise(const CataloguedEffect& effect);

/// Whether a search tries it only where no other helps: rare effects, and laws that are learnt.
bool is_tried_last(const CataloguedEffect& effect);

/// Whether its states are faster while the arm moves than a linear model about rest tells.
bool is_fast_in_motion(const CataloguedEffect& effect);

/// The parameters of an effect in the catalogue and its states, with what is usual of an arm so
/// many times as heavy as the published one, and the arm's parameters that it sets free.
std::vector<EffectParameter> parameters_of(const CataloguedEffect& effect, double heaviness = 1.0);
std::vector<EffectState> states_of(const CataloguedEffect& effect, double heaviness = 1.0);
std::vector<std::string_view> freed_by(const CataloguedEffect& effect);

}  // namespace armukf
