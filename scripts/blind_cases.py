"""What blind_score.py tries: which effects, how large, on which seeds.

A seed stands for a world of its own, drawn by blind_plant: an arm with every physical value within
30 % of the published one, its sensor and torque noise, its controller and the motions it is led
through. No two cases share a seed, and so none shares an arm; the halves least of all.
"""

import math
import random
from dataclasses import dataclass

CATALOGUE = ["torque_bias", "torque_gain", "torque_ripple", "input_delay", "drive_lag",
             "friction_parameters", "coulomb_asymmetry", "gear_friction", "arm_friction",
             "load_dependent_friction", "thermal_friction", "presliding_friction", "backlash",
             "gear_hysteresis", "gear_damping_quadratic", "arm_stiffness_cubic",
             "flexible_mode.motor", "flexible_mode.gear", "flexible_mode.arm", "gravity",
             "payload_change", "sensor_lag", "speed_ripple"]
FOREIGN = ["external_7hz", "two_modes", "torque_saturation", "friction_step", "two_hystereses",
           "gear_softening", "gear_asymmetry", "position_friction", "arm_backlash",
           "sensor_coupling_60hz", "sensor_dropouts", "sensor_counts"]

# Names that count as one, and why: (the name they count by, those that do, the reason).
CLASSES = [
    ("flexible_mode", ("flexible_mode.motor", "flexible_mode.gear", "flexible_mode.arm"),
     "an oscillator on another mass gives the motor's speed a pair of poles and zeros as well; "
     "which mass carries it shows only in how far the two lie apart"),
]
# Any two of these in one arm are, to first order, one delay of their sum, which no name tells apart;
# so no pair is made of them. Alone each counts by its own name.
ONE_DELAY = {"input_delay", "drive_lag", "sensor_lag"}

# Validation error over that of the same seed without the effect: what a case counts with, and what
# is aimed at, within it by the tolerance of blind_calibration.
COUNTED_GROWTH = 1.3, 40.0
WANTED_GROWTH = 1.4, 33.0

HALVES = {"tuning": 1_000_000, "score": 4_000_000}
GROUPS = {"null": 0, "single": 100_000, "several": 200_000, "foreign": 300_000}
# Records of a group; of single and foreign for each of their effects. Every third of several has
# three effects, the others two.
COUNTS = {"tuning": {"null": 60, "single": 4, "several": 12, "foreign": 1},
          "score": {"null": 100, "single": 10, "several": 30, "foreign": 3}}


@dataclass(frozen=True)
class Case:
    group: str
    seed: int
    wanted: tuple = ()  # of (name, growth that it alone is to make)

    @property
    def names(self):
        return tuple(name for name, _ in self.wanted)


def counts_as(name):
    """The name by which an effect is scored, whatever its spelling; a second one counts as the first."""
    plain = name.split(":")[0]
    for of_class, names, _ in CLASSES:
        if plain in (of_class, *names, *(n.replace(".", "_") for n in names)):
            return of_class
    return plain


def growth_at(part, share=1):
    """Log-uniform over what is wanted of one of `share` effects, 0 <= part < 1."""
    least, most = WANTED_GROWTH
    return least * (((most - 1) / share + 1) / least) ** part


def part_at(growth, share=1):
    """Inverse of growth_at."""
    return math.log(growth / growth_at(0, share)) / math.log(growth_at(1, share) / growth_at(0, share))


def drawn_names(count, draw):
    names = []
    while len(names) < count:
        name = CATALOGUE[int(len(CATALOGUE) * draw.random())]
        if counts_as(name) not in map(counts_as, names) and not (
                name in ONE_DELAY and ONE_DELAY & set(names)):
            names.append(name)
    return names


def drawn_case(group, seed, names=None):
    draw = random.Random(seed)
    if group == "several":
        names = drawn_names(3 if seed % 3 == 2 else 2, draw)
    return Case(group, seed, tuple((n, growth_at(draw.random(), len(names))) for n in names))


def cases_of(half, group):
    first = HALVES[half] + GROUPS[group]
    numbers = range(COUNTS[half][group])
    if group == "null":
        return [Case(group, first + n) for n in numbers]
    if group == "several":
        return [drawn_case(group, first + n) for n in numbers]
    effects = FOREIGN if group == "foreign" else CATALOGUE
    return [drawn_case(group, first + 100 * i + n, [name])
            for i, name in enumerate(effects) for n in numbers]
