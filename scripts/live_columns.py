"""The columns of what `armukf estimate` writes: which are states, in what units, and what a bin keeps of them."""

import math
import re
from array import array
from operator import itemgetter

STATES = {
    "rad": "twist_gear twist_arm angle_curve_angle gravity_angle speed_ripple_angle speed_ripple_constant_angle "
           "torque_ripple_angle torque_ripple_commanded_angle friction_ripple_angle external_torque_phase "
           "external_torque_arm_phase gear_stiffness_ripple_angle transmission_error_angle pose_inertia_angle "
           "mode_motor_deflection mode_gear_deflection mode_arm_deflection gear_relaxation_deflection",
    "rad/s": "speed_motor speed_gear speed_arm sensor_speed sensor_coupling_speed friction_lag_speed mode_motor_speed "
             "mode_gear_speed mode_arm_speed",
    "rad/s²": "sensor_coupling_rate",
    "N·m": "drive_torque drive_response drive_response_rate input_delay_first input_delay_second drive_notch_band "
           "torque_slewed presliding_torque",
    "N·m·s": "drive_notch_passed gear_slip_load",
    "–": "presliding_deflection gear_hysteresis_deflection arm_hysteresis_deflection thermal_heated_warmth "
         "thermal_torque_warmth"}
PARAMETERS = {
    "N·m": "Fc Fcs arm_friction_coulomb gear_friction_coulomb coulomb_asymmetry gear_hysteresis arm_hysteresis "
           "gravity presliding_friction torque_bias torque_ripple torque_curve_range external_torque "
           "external_torque_arm friction_change friction_change_before friction_ripple gear_slip_torque torque_limit "
           "thermal_torque_heated_torque",
    "N·m/s": "torque_slew",
    "N·m·s/rad": "Fv d_g d_a arm_friction_viscous gear_friction_viscous torque_limit_fall",
    "N·m·s²/rad²": "gear_damping_quadratic",
    "N·m/rad": "k_g1 k_a gear_relaxation",
    "rad/(N·m·s)": "gear_slip",
    "rad/(N·m)": "presliding_compliance",
    "N·m/rad³": "k_g3 arm_stiffness_cubic",
    "kg·m²": "J",
    "s/rad": "alpha beta sensor_gain_bend",
    "s": "drive_lag_time drive_response_time input_delay payload_time payload_until sensor_lag_time "
         "thermal_friction_time thermal_cold_time friction_change_time friction_change_until thermal_torque_time "
         "thermal_torque_heated_time thermal_damping_time thermal_heated_time gear_relaxation_time "
         "gear_stiffness_change_time arm_stiffness_change_time friction_lag_time",
    "rad": "backlash arm_backlash transmission_error gear_hysteresis_distance arm_hysteresis_distance "
           "presliding_distance gear_spring_curve_range arm_spring_curve_range",
    "rad/s": "friction_curve_range sensor_curve_range speed_ripple_constant",
    "1/rad": "angle_curve_harmonic speed_ripple_harmonic speed_ripple_constant_harmonic torque_ripple_harmonic "
             "torque_ripple_commanded_harmonic friction_ripple_harmonic gear_stiffness_ripple_harmonic "
             "transmission_error_harmonic pose_inertia_harmonic",
    "Hz": "mode_motor_frequency mode_gear_frequency mode_arm_frequency external_torque_frequency "
          "external_torque_arm_frequency sensor_coupling_frequency drive_notch_frequency",
    "–": "a_m a_g load_dependent_friction payload presliding_share speed_ripple thermal_friction torque_gain "
         "mode_motor_share mode_gear_share mode_arm_share mode_motor_damping mode_gear_damping mode_arm_damping "
         "coulomb_asymmetry_side mode_motor_on_top mode_gear_on_top mode_arm_on_top backlash_damping "
         "drive_response_damping sensor_coupling_share sensor_coupling_damping gravity_ratio thermal_torque "
         "thermal_torque_heated thermal_damping gear_stiffness_ripple pose_inertia torque_ripple_commanded "
         "thermal_friction_heated thermal_friction_cold thermal_friction_viscous thermal_heated_viscous "
         "thermal_cold_viscous gear_stiffness_change arm_stiffness_change torque_limit_share torque_slew_share "
         "friction_lag_share drive_notch drive_notch_damping sensor_gain sensor_gain_asymmetry"}
LEARNT_LAWS = {"N·m": re.compile(r"(friction|gear_spring|arm_spring|torque|angle)_curve_(odd|even|cos|sin)_[a-d]"),
               "rad/s": re.compile(r"sensor_curve_(odd|even)_[a-e]")}
UNITS = {name: unit for kind in (STATES, PARAMETERS) for unit, names in kind.items() for name in names.split()}
STATE_NAMES = {name for names in STATES.values() for name in names.split()}

NEEDED = ["t", "innovation", "innovation_sd", "nis", "status"]
COUNTS = ["rows", "missing", "rejected", "gap", "reset"]


class InputError(Exception):
    """What is wrong with the user's input, in one line."""


def base(name):
    """Of an effect that the model has several times."""
    return re.sub(r"_\d+$", "", name)


def unit_of(name):
    of_law = (unit for unit, sizes in LEARNT_LAWS.items() if sizes.fullmatch(base(name)))
    return next(of_law, UNITS.get(base(name), ""))


def is_state(name):
    return base(name) in STATE_NAMES


def last(values):
    return values[-1]


def lowest(values):
    return min((v for v in values if v == v), default=math.nan)


def highest(values):
    return max((v for v in values if v == v), default=math.nan)


class Layout:
    """Where a stream's columns are, and what a bin tells of them."""

    def __init__(self, header):
        self.names = header.decode("utf-8", "replace").strip().split(",")
        at = {name: i for i, name in enumerate(self.names)}
        for name in NEEDED:
            if name not in at:
                raise InputError(f"no column {name}; is it what `armukf estimate` writes?")
        self.t, self.status, self.innovation_sd = at["t"], at["status"], at["innovation_sd"]
        self.keyed = self.t == 1  # the arm's name stands in front
        shown = [name for name in self.names[self.status + 1:] if name + "_sd" in at]
        self.states = [name for name in shown if is_state(name)]
        self.parameters = [name for name in shown if not is_state(name)]
        self.of_each_row = itemgetter(*(at[name] for name in ["innovation", "nis", *self.states]))
        self.sd_of_states = [at[name + "_sd"] for name in self.states]
        self.of_parameters = [at[name + end] for name in self.parameters for end in ("", "_sd")]
        self.fields, self.merges = zip(*self.described())
        self.at = {name: i for i, name in enumerate(self.fields)}

    def described(self):
        """A bin's fields, each with how those of several bins become one."""
        yield from [("level", last), ("t", last)]
        yield from [(name, sum) for name in COUNTS]
        yield from [("innovation_min", lowest), ("innovation_max", highest), ("innovation_sd", last)]
        yield "nis", last  # a mean: see mean_nis()
        for name in self.states:
            yield from [(name, last), (name + "_min", lowest), (name + "_max", highest), (name + "_sd", last)]
        for name in self.parameters:
            yield from [(name, last), (name + "_sd", last)]

    def merged(self, bins):
        one = array("d", [merge(column) for merge, column in zip(self.merges, zip(*bins))])
        one[self.at["nis"]] = self.mean_nis(bins)
        return one

    def mean_nis(self, bins):
        rows, missing, nis = (self.at[name] for name in ("rows", "missing", "nis"))
        weights = [(bin[rows] - bin[missing], bin[nis]) for bin in bins if bin[nis] == bin[nis]]
        measured = sum(weight for weight, _ in weights)
        return sum(weight * value for weight, value in weights) / measured if measured else math.nan

    def told(self):
        """What a page needs to read bins."""
        units = {name: unit_of(name) for name in self.states + self.parameters}
        return {"fields": self.fields, "states": self.states, "parameters": self.parameters, "units": units}
