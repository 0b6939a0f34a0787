#!/usr/bin/python3
"""The blind plant beside armukf, by what both say of the same numbers: without noise, an arm of which
armukf is told all that is true leaves no error. Usage: plant_test.py BLIND_PLANT ARMUKF"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PLANT, ARMUKF = sys.argv[1:3]
SEEDS = (11, 12, 14)  # between them each kind of motion, with and without an integrator
EXACT = 1e-8  # (rad/s)^2, of what both integrators leave at the plant's step
# At one step a sample, as by default, armukf errs by up to 6e-4 rad/s where the motor reverses fast.
STEPS = "[propagation]\nsteps = 4\n"


def arm_inertia(arm):
    return arm["J"] * (1 - arm["a_m"] - arm["a_g"])


def mode(truth):
    oscillator = truth["oscillators"][0]
    return {f"mode_{oscillator['site']}_{n}": v for n, v in oscillator["at"].items()}


# The plant's effect and size; of its error without the effect, the part that armukf with the true
# numbers may leave; those numbers, of the plant's e and the arm a.
EFFECTS = [
    ("torque_bias", 0.3, 0.0, lambda e, a: {"torque_bias": e["torque_bias"]}),
    ("torque_gain", 0.1, 0.0, lambda e, a: {"torque_gain": e["torque_gain"] - 1}),
    ("torque_ripple", 0.5, 0.0, lambda e, a: {
        "torque_ripple": e["torque_ripple"], "torque_ripple_harmonic": e["torque_ripple_order"]}),
    # Here whatever part of a sample the delay cuts off; armukf has two states for it.
    ("input_delay", 0.0015, 0.005, lambda e, a: {"input_delay": e["input_delay"]}),
    # Of both lags armukf leaves an error of 10 to 50 Hz, about 4 % of the lag's amplitude.
    ("drive_lag", 0.0015, 0.005, lambda e, a: {"drive_lag_time": e["drive_lag"]}),
    ("friction_parameters", 0.2, 0.0, lambda e, a: {
        n: a[n] * e[f"{n}_factor"] for n in ("Fv", "Fc", "Fcs", "alpha", "beta")}),
    # Here a Fc tanh(beta w)^2, which passes through zero at standstill.
    ("coulomb_asymmetry", 0.2, 0.005, lambda e, a: {
        "coulomb_asymmetry": e["coulomb_asymmetry"] * a["Fc"]}),
    ("gear_friction", 0.3, 0.0, lambda e, a: {
        "gear_friction_coulomb": e["gear_coulomb"], "gear_friction_viscous": e["gear_viscous"]}),
    ("arm_friction", 0.3, 0.0, lambda e, a: {
        "arm_friction_coulomb": e["arm_coulomb"], "arm_friction_viscous": e["arm_viscous"]}),
    # Here |tau_s| has its corner at zero.
    ("load_dependent_friction", 0.1, 0.001, lambda e, a: {
        "load_dependent_friction": e["load_friction"]}),
    ("thermal_friction", 0.3, 0.0, lambda e, a: {
        "thermal_friction": -e["thermal_loss"], "thermal_friction_time": e["thermal_time"]}),
    # Here Coulomb and Stribeck torque follow the way together.
    ("presliding_friction", 0.1, 0.05, lambda e, a: {
        "presliding_friction": a["Fc"], "presliding_distance": e["presliding_way"],
        "presliding_share": 1.0}),
    # Here the gap has sharp edges.
    ("backlash", 0.02, 0.001, lambda e, a: {"backlash": e["backlash"]}),
    # Here Wen's law with 0.6 and 0.4.
    ("gear_hysteresis", 0.5, 0.03, lambda e, a: {
        "gear_hysteresis": e["gear_hysteresis"],
        "gear_hysteresis_distance": e["gear_hysteresis_twist"]}),
    ("gear_damping_quadratic", 0.02, 0.0, lambda e, a: {
        "gear_damping_quadratic": e["gear_damping_quadratic"]}),
    ("arm_stiffness_cubic", 100, 0.0, lambda e, a: {"arm_stiffness_cubic": e["arm_stiffness_cubic"]}),
    ("flexible_mode.motor", 0.2, 0.0, None),
    ("flexible_mode.gear", 0.2, 0.0, None),
    ("flexible_mode.arm", 0.2, 0.0, None),
    ("gravity", 0.5, 0.0, lambda e, a: {"gravity": e["gravity"]}),
    ("payload_change", 0.002, 0.0, lambda e, a: {"payload": e["payload"] / arm_inertia(a)}),
    ("sensor_lag", 0.001, 0.005, lambda e, a: {"sensor_lag_time": e["sensor_lag"]}),
    # Here a wave along the true angle; along the measured one it differs by the ripple squared.
    ("speed_ripple", 0.05, 0.005, lambda e, a: {
        "speed_ripple": e["speed_ripple"], "speed_ripple_harmonic": e["speed_ripple_order"]}),
]


def answer(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return done.stdout


class Plant(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.record, self.truth = Path(folder.name, "record.csv"), Path(folder.name, "truth.json")
        self.steps = Path(folder.name, "steps.toml")
        self.steps.write_text(STEPS)

    def calm(self, seed, *effects):
        answer(PLANT, "--seed", seed, "--noise-factor", 0, "--estimation", self.record,
               "--truth", self.truth, *(x for e in effects for x in ("--effect", e)))
        return json.loads(self.truth.read_text())

    def error(self, values, *effects):
        told = [x for n, v in values.items() for x in ("--set", f"{n}={v!r}")]
        out = answer(ARMUKF, "evaluate", self.record, "--model", self.steps, "--free-initial", "all", *told, "--json", "-",
                     "--quiet", *(x for e in effects for x in ("--effect", e)))
        return json.loads(out)["experiments"][0]["mse"]

    def test_bare_arm_is_that_of_the_contract(self):
        for seed in SEEDS:
            with self.subTest(seed=seed):
                self.assertLess(self.error(self.calm(seed)["arm"]), EXACT)

    def test_effects_are_what_their_names_say(self):
        for name, size, left, numbers in EFFECTS:
            with self.subTest(effect=name):
                truth = self.calm(SEEDS[1], f"{name}={size}")
                values = numbers(truth["effects"], truth["arm"]) if numbers else mode(truth)
                plain = self.error(truth["arm"])
                told = self.error({**truth["arm"], **values}, name.replace(".", "_"))
                self.assertLess(told, EXACT + left * plain)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
