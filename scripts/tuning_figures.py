#!/usr/bin/python3
"""Checks what tune.py finds against what is known.

    tuning_figures.py known      [--records 10] simulated records of known noise, from starts that are 10 times off
    tuning_figures.py measured   the measured record, tuned on its first 70 %, judged on the rest

--starts N: of each search, 2 by default.

The measured record is $ARMUKF_MEASURED/robotarm_estimation.csv; without it that job skips (exit status
77). Exit status 1: a figure is missed.
"""

import argparse
import math
import sys
import tempfile
from pathlib import Path

import sweeps
import tune
from recursive_figures import Checks, measured_record

SENSOR, DISTURBANCE, SAMPLE_TIME = 0.1, 0.2, 5e-4  # rad/s; N.m held per sample; s


def options_for(options, *words):
    return tune.options_of([*map(str, words), "--program", options.program])


def known(options, pool, checks):
    torque = DISTURBANCE * math.sqrt(SAMPLE_TIME)
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, options.records + 1):
            records = [sweeps.simulate(options.program, f"{folder}/{s}.csv", s, SENSOR, DISTURBANCE)
                       for s in (seed, 100 + seed)]
            off = 10.0 if seed % 2 else 0.1
            wrong = Path(folder, "wrong.toml")
            wrong.write_text(tune.toml_text(tune.known_noise(SENSOR * off, torque / off)))
            o = options_for(options, records[0], "--validate", records[1], "--model", wrong, "--tune",
                            "noise.sensor", "noise.motor_torque", "--starts", options.starts)
            result = tune.tuned(o, pool)
            found = {n: e["value"] for n, e in result["tuned"].items()}
            truth = tune.judged(o, tune.known_noise(SENSOR, torque), {}, [(records[0], None)])
            lost = (truth["validation"]["log_likelihood_per_sample"] -
                    result["after"]["validation"]["log_likelihood_per_sample"])
            sensor = 100 * (found["noise.sensor"] / SENSOR - 1)
            noise = 100 * (found["noise.motor_torque"] / torque - 1)
            checks.expect(abs(sensor) <= 5 and abs(noise) <= 25 and lost <= 0.01,
                          f"seed {seed:2}: sensor noise {sensor:+.1f} % (5), torque noise {noise:+.1f} % (25), "
                          f"held-out log-likelihood {lost:+.4f} per sample below the truth's (0.01)")


def measured(options, pool, checks):
    result = tune.tuned(options_for(options, measured_record(), "--keep-fit", 0.2, "--starts", options.starts), pool)
    print(tune.text_of(result))
    before, after = (result[k]["validation"] for k in ("before", "after"))
    checks.expect(after["log_likelihood_per_sample"] > before["log_likelihood_per_sample"],
                  f"held-out log-likelihood per sample {after['log_likelihood_per_sample']:.3f} "
                  f"(before {before['log_likelihood_per_sample']:.3f})")
    checks.expect(0.9 <= after["mean_nis"] <= 1.1, f"held-out mean NIS {after['mean_nis']:.3f} (0.9 to 1.1; "
                  f"before {before['mean_nis']:.3f})")
    fits = [result[k]["simulation_fit_percent"] for k in ("before", "after")]
    checks.expect(fits[1] >= fits[0] - 0.3, f"simulation fit {fits[1]:.2f} % (before {fits[0]:.2f}, at most "
                  "0.3 less); every parameter physical")


def main():
    jobs = {"known": known, "measured": measured}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("job", choices=jobs)
    parser.add_argument("--program", default=str(sweeps.PROGRAM))
    parser.add_argument("--records", type=int, default=10)
    parser.add_argument("--starts", type=int, default=2, help="of a search")
    options = parser.parse_args()
    checks = Checks()
    with sweeps.pool() as pool:
        jobs[options.job](options, pool, checks)
    return 1 if checks.missed else 0


if __name__ == "__main__":
    sweeps.run_script(main)
