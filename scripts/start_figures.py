#!/usr/bin/python3
"""Measures what start values from scratch must reach, by the program itself.

    start_figures.py slow|frequency [--program ARMUKF] [--arms 20]

slow       friction and inertia from simulated records of slow motion, one an arm
frequency  fits from the frequency response against fits from the truth, on simulated arms with
           parameters drawn 40 % about the published estimate, and on the measured record where
           ARMUKF_MEASURED names its folder

Exit status 0 if every figure is met, 1 if not.
"""

import argparse
import math
import os
import random
import sys
import tempfile
from pathlib import Path

from recursive_figures import TRUTH, armukf
from sweeps import INERTIA

FRICTION = {"Fv": 0.00986346744839, "Fc": 0.74302635727901, "Fcs": 3.98628540790595,
            "alpha": 3.24015074090438, "beta": 0.79943497008153}
MEASURED_MSE = 9.467  # (rad/s)^2, of the published minimum


def friction(p, w):
    """Torque (N.m) at the speed w (rad/s), to judge a curve by: the contract's equation."""
    return p["Fv"] * w + (p["Fc"] + p["Fcs"] / math.cosh(min(p["alpha"] * w, 700))) * math.tanh(
        p["beta"] * w)


def slow(program, folder, arms):
    worst_inertia = worst_curve = 0.0
    for seed in range(1, arms + 1):
        record = folder / "slow.csv"
        armukf(program, "simulate", "-o", record, "--experiment", "validation3", "--seed", seed,
               "--sensor-noise", 0.05)
        # The springs matter little here: the fit is only there to tell the start values.
        found = armukf(program, "fit", record, "--start", "slow", record, "--iterations", 1,
                       "--no-blocks")["parameters"]
        p = {name: found[name]["value"] for name in (*FRICTION, "J")}
        worst_inertia = max(worst_inertia, abs(p["J"] / INERTIA - 1))
        worst_curve = max(worst_curve, *(abs(friction(p, w) / friction(FRICTION, w) - 1)
                                         for w in (1 + 0.1 * k for k in range(391))))
    print(f"slow: J within {100 * worst_inertia:.2f} % (asked 2), friction torque over 1-40 rad/s "
          f"within {100 * worst_curve:.2f} % (asked 3)")
    return worst_inertia <= 0.02 and worst_curve <= 0.03


def drawn_arm(generator):
    """The published estimate with each parameter 40 % up or down at most; the arm keeps a share."""
    while True:
        arm = {name: value * (1 + generator.uniform(-0.4, 0.4)) for name, value in TRUTH.items()}
        if arm["a_m"] + arm["a_g"] < 0.97:
            return arm


def same_minimum(program, record, arm):
    """Whether the fit from the frequency response ends as low as the one from the truth."""
    truth = [f"--set={name}={value}" for name, value in arm.items()]
    common = ["fit", record, "--free-initial", "all", "--no-blocks"]
    from_truth = armukf(program, *common, *truth)["mse"]
    found = armukf(program, *common, "--start", "frequency")["mse"]
    return found <= from_truth * 1.001, found, from_truth


def frequency(program, folder, arms):
    generator = random.Random(1)
    good = 0
    for k in range(arms):
        arm = drawn_arm(generator)
        record = folder / "record.csv"
        armukf(program, "simulate", "-o", record, "--seed", k + 1, "--sensor-noise", 0.05,
               *(f"--set={name}={value}" for name, value in arm.items()))
        same, found, from_truth = same_minimum(program, record, arm)
        good += same
        if not same:
            print(f"  arm {k + 1}: MSE {found:.5g}, from the truth {from_truth:.5g}: "
                  + ", ".join(f"{name} {value:.4g}" for name, value in arm.items()))
    print(f"frequency: {good} of {arms} arms reach the minimum of the truth (asked 19 of 20)")
    return good >= math.ceil(0.95 * arms) and measured(program)


def measured(program):
    if not (folder := os.environ.get("ARMUKF_MEASURED")):
        print("  the measured record is skipped: ARMUKF_MEASURED is not set")
        return True
    record = Path(folder) / "robotarm_estimation.csv"
    mse = armukf(program, "fit", record, "--start", "frequency", "--no-blocks")["mse"]
    print(f"  measured record: MSE {mse:.5g} (asked {MEASURED_MSE})")
    return mse <= MEASURED_MSE


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("job", choices=["slow", "frequency"])
    parser.add_argument("--program", default="build/release/bin/armukf")
    parser.add_argument("--arms", type=int, default=20)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        job = {"slow": slow, "frequency": frequency}[options.job]
        return 0 if job(options.program, Path(folder), options.arms) else 1


if __name__ == "__main__":
    sys.exit(main())
