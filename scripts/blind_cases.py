"""What blind_score.py tries: arms, effects and their sizes, and the programs that answer."""

import json
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parent.parent
SIZES = ROOT / "tests/blind/sizes.json"

CATALOGUE = ["torque_bias", "torque_gain", "torque_ripple", "input_delay", "drive_lag",
             "friction_parameters", "coulomb_asymmetry", "gear_friction", "arm_friction",
             "load_dependent_friction", "thermal_friction", "presliding_friction", "backlash",
             "gear_hysteresis", "gear_damping_quadratic", "arm_stiffness_cubic",
             "flexible_mode.motor", "flexible_mode.gear", "flexible_mode.arm", "gravity",
             "payload_change", "sensor_lag", "speed_ripple"]
FOREIGN = ["external_7hz", "two_modes", "torque_saturation", "friction_step", "two_hystereses"]
PAIRS = [("flexible_mode.motor", "torque_bias"), ("backlash", "gravity"),
         ("torque_ripple", "input_delay"), ("arm_friction", "gear_damping_quadratic")]

# Twists are not zero when a record of an arm in motion begins.
INITIAL = ["--free-initial", "all"]
# From its one default start the fit of some arms ends in a local minimum, of ten times the error.
SEARCHES = ["--starts", "6"]


@dataclass(frozen=True)
class Surroundings:
    """Arm, controller and sensor noise (sd in rad/s, pole) of a record."""
    arm: int
    controller: int
    noise: float
    pole: float


SURROUNDINGS = [Surroundings(0, 0, 0.2, 0.0), Surroundings(1, 1, 0.1, 0.0),
                Surroundings(2, 2, 0.3, 0.0), Surroundings(3, 0, 0.5, 0.5),
                Surroundings(4, 1, 0.2, 0.9), Surroundings(5, 2, 0.1, 0.0)]


def surroundings_of(seed):
    """Seeds take turns with the surroundings, from seed 1 on."""
    return SURROUNDINGS[(seed - 1) % len(SURROUNDINGS)]


@dataclass(frozen=True)
class Case:
    group: str
    effects: tuple  # of (name, size)
    seed: int

    @property
    def surroundings(self):
        return surroundings_of(self.seed)

    @property
    def title(self):
        return " + ".join(name for name, _ in self.effects) or "none"


@dataclass(frozen=True)
class Programs:
    armukf: str
    plant: str
    diagnose_options: tuple = ()
    timeout_s: float = 900.0


class Failure(Exception):
    """A program that did not answer."""


def called(command, timeout_s):
    try:
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True,
                              timeout=timeout_s)
    except subprocess.TimeoutExpired:
        raise Failure("timeout")
    if done.returncode != 0:
        raise Failure(done.stderr.strip() or f"exit status {done.returncode}")
    return done.stdout


def make_records(programs, effects, seed, folder):
    """Estimation and validation record of an arm with these effects."""
    s = surroundings_of(seed)
    records = Path(folder, "estimation.csv"), Path(folder, "validation.csv")
    command = [programs.plant, "--seed", seed, "--noise", s.noise, "--noise-pole", s.pole,
               "--arm", s.arm, "--controller", s.controller,
               "--estimation", records[0], "--validation", records[1]]
    for name, size in effects:
        command += ["--effect", f"{name}={size}"]
    called(command, programs.timeout_s)
    return records


def fitted_error(programs, records, effects=()):
    """MSE on the validation record of what fits the estimation record."""
    estimation, validation = records
    model = Path(estimation).with_name("model.toml")
    fit = [programs.armukf, "fit", estimation, *INITIAL, *SEARCHES, "--save", model,
           "--json", "-", "--quiet"]
    for name in effects:
        fit += ["--effect", name]
    called(fit, programs.timeout_s)
    answer = called([programs.armukf, "evaluate", validation, *INITIAL, "--model", model,
                     "--json", "-", "--quiet"], programs.timeout_s)
    return json.loads(answer)["experiments"][0]["mse"]


def base(name):
    """A flexible mode counts by whatever name its site goes."""
    return "flexible_mode" if name.startswith("flexible_mode") else name


def spellings(name):
    """The names under which armukf may know the effect."""
    return list(dict.fromkeys([name.replace(".", "_"), name, base(name)]))


def plain_error(programs, effects, seed):
    """Validation MSE of the model without effects on a record with them."""
    with tempfile.TemporaryDirectory() as folder:
        return fitted_error(programs, make_records(programs, effects, seed, folder))


def in_parallel(job, items, jobs):
    """The answers in the order of the items; a line of progress on a terminal."""
    answers = []
    with ThreadPoolExecutor(jobs) as pool:
        for answer in pool.map(job, items):
            answers.append(answer)
            if sys.stderr.isatty():
                print(f"\r{len(answers)} of {len(items)}", end="", file=sys.stderr, flush=True)
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    return answers
