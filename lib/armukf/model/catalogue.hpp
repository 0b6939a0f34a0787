#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "armukf/model/effects/arm_friction.hpp"
#include "armukf/model/effects/arm_stiffness_cubic.hpp"
#include "armukf/model/effects/backlash.hpp"
#include "armukf/model/effects/coulomb_asymmetry.hpp"
#include "armukf/model/effects/drive_lag.hpp"
#include "armukf/model/effects/flexible_mode.hpp"
#include "armukf/model/effects/friction_parameters.hpp"
#include "armukf/model/effects/gear_damping_quadratic.hpp"
#include "armukf/model/effects/gear_friction.hpp"
#include "armukf/model/effects/gear_hysteresis.hpp"
#include "armukf/model/effects/gravity.hpp"
#include "armukf/model/effects/input_delay.hpp"
#include "armukf/model/effects/load_dependent_friction.hpp"
#include "armukf/model/effects/payload_change.hpp"
#include "armukf/model/effects/presliding_friction.hpp"
#include "armukf/model/effects/sensor_lag.hpp"
#include "armukf/model/effects/speed_ripple.hpp"
#include "armukf/model/effects/thermal_friction.hpp"
#include "armukf/model/effects/torque_bias.hpp"
#include "armukf/model/effects/torque_gain.hpp"
#include "armukf/model/effects/torque_ripple.hpp"

namespace armukf {

/// Every effect that a model may have. A new one is a header in effects/ and one line here.
using CataloguedEffect = std::variant<
    effects::TorqueBias, effects::TorqueGain, effects::TorqueRipple, effects::InputDelay,
    effects::DriveLag, effects::FrictionParameters, effects::CoulombAsymmetry,
    effects::GearFriction, effects::ArmFriction, effects::LoadDependentFriction,
    effects::ThermalFriction, effects::PreslidingFriction, effects::Backlash,
    effects::GearHysteresis, effects::GearDampingQuadratic, effects::ArmStiffnessCubic,
    effects::FlexibleMode<effects::Site::kArm>, effects::FlexibleMode<effects::Site::kGear>,
    effects::FlexibleMode<effects::Site::kMotor>, effects::Gravity, effects::PayloadChange,
    effects::SensorLag, effects::SpeedRipple>;

/// The effect of that name; throws InputError that lists the known names. `flexible_mode` without a
/// site is the one at the arm.
CataloguedEffect find_effect(std::string_view name);

/// The names in the catalogue, in its order.
std::vector<std::string_view> effect_names();

/// What an effect and its relatives at other sites are called together: `flexible_mode` for
/// `flexible_mode_gear`, its own name for any other.
std::string family_of(std::string_view effect);

/// The parameters of an effect in the catalogue.
std::vector<EffectParameter> parameters_of(const CataloguedEffect& effect);

}  // namespace armukf
