#!/usr/bin/python3
"""Seeds x arms x settings: how far off the recursive estimate is, and whether its intervals are honest.

    montecarlo.py --seeds 50 --arms 2 --filters ukf ekf --settings default known

Each run simulates a record and goes over it once. Arm 0 is the published one, others have parameters
drawn about it. Settings: default, known (data/known_noise.toml with the record's noise put in), or a
model file. Per filter and setting, for each parameter: bias and RMSE in percent of the truth, and how
often the 90 % interval holds it (90 if the filter is honest). A run is lost if armukf fails, or if it ends
unphysical, with a reset, or with a simulation fit below 80 %. The interval of a lost run holds nothing;
bias and RMSE are those of the runs that are left.
"""

import argparse
import itertools
import math
import statistics
import tempfile
from pathlib import Path

import sweeps
import tune
from sweeps import TRUTH, Trouble

LEAST_FIT = 80.0  # percent
SAMPLE_TIME = 5e-4  # s, over which a disturbance is held


def run(item):
    """One record, one pass: parameters, their deviations, and what became of the run."""
    truth = sweeps.random_arm(item["arm"], item["spread"])
    with tempfile.TemporaryDirectory() as folder:
        record = sweeps.simulate(item["program"], Path(folder, "record.csv"), item["seed"], item["noise"],
                                 item["disturbance"], truth)
        model = Path(folder, "model.toml")
        model.write_text(item["model"])
        try:
            result = sweeps.armukf(item["program"], "estimate", record, "--model", model, "--filter",
                                   item["filter"])
        except sweeps.Failed:
            return {"lost": True}
    fit = result["simulation"]["fit_percent"]
    parameters = {p: [result["parameters"][p]["value"], result["parameters"][p]["sd"]] for p in TRUTH}
    nis = result["innovation"]["mean_nis"]
    numbers = [nis, *itertools.chain(*parameters.values())]
    lost = not (sweeps.physical(result) and sweeps.finite(numbers)) or result["resets"] > 0 or fit < LEAST_FIT
    return {"lost": lost, "parameters": parameters, "nis": nis, "fit": fit}


def summary(items, results):
    """Of the runs of one filter with one setting."""
    runs = [(sweeps.random_arm(i["arm"], i["spread"]), r) for i, r in zip(items, results) if not r["lost"]]
    table = {}
    for p in TRUTH:
        errors = [100 * (r["parameters"][p][0] / truth[p] - 1) for truth, r in runs]
        inside = sum(abs(r["parameters"][p][0] - truth[p]) < 1.645 * r["parameters"][p][1] for truth, r in runs)
        table[p] = {"bias_percent": statistics.mean(errors) if runs else None,
                    "coverage_percent": 100 * inside / len(results),
                    "rmse_percent": math.sqrt(statistics.mean(e * e for e in errors)) if runs else None}
    return {"runs": len(results), "lost": len(results) - len(runs), "parameters": table,
            "mean_nis": statistics.mean(r["nis"] for _, r in runs) if runs else None,
            "fit_percent": statistics.mean(r["fit"] for _, r in runs) if runs else None}


def text_of(name, s):
    lines = [f"## {name}", "", f"{s['runs']} runs, {s['lost']} lost" + (
        f", mean NIS {s['mean_nis']:.3f}, simulation fit {s['fit_percent']:.2f} %" if s["mean_nis"] else ""), "",
        "| parameter | bias % | RMSE % | 90 % interval holds the truth in % |", "|---|---|---|---|"]
    for p, e in s["parameters"].items():
        bias, rmse = (("-", "-") if e["bias_percent"] is None else
                      (f"{e['bias_percent']:+.2f}", f"{e['rmse_percent']:.2f}"))
        lines.append(f"| {p} | {bias} | {rmse} | {e['coverage_percent']:.0f} |")
    return "\n".join(lines) + "\n"


def setting_text(name, options):
    if name == "default":
        return ""
    if name == "known":
        density = options.torque_disturbance * math.sqrt(SAMPLE_TIME)
        return tune.toml_text(tune.known_noise(options.sensor_noise, density))
    try:
        return Path(name).read_text()
    except OSError as error:
        raise Trouble(f"--settings: {name} is not default, not known, and no file: {error.strerror}") from error


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, help="records of each arm")
    parser.add_argument("--arms", type=int, default=1)
    parser.add_argument("--spread", type=float, default=0.2, help="of the arms' parameters, sd of the logarithm")
    parser.add_argument("--filters", nargs="+", default=["ukf", "ekf"])
    parser.add_argument("--settings", nargs="+", default=["default"], help="default, known, or model files")
    parser.add_argument("--sensor-noise", type=float, default=0.1, help="rad/s")
    parser.add_argument("--torque-disturbance", type=float, default=0.1, help="N.m, held per sample")
    sweeps.add_options(parser)
    o = parser.parse_args()
    groups = list(itertools.product(o.settings, o.filters))
    items = [{"program": str(Path(o.program).resolve()), "filter": f, "model": setting_text(s, o), "arm": arm,
              "spread": o.spread, "seed": seed, "noise": o.sensor_noise, "disturbance": o.torque_disturbance}
             for s, f in groups for arm in range(o.arms) for seed in range(1, o.seeds + 1)]
    with sweeps.pool(o.workers, o.scheduler) as pool:
        results = pool.map(run, items, sweeps.Ledger(o.state), "runs")
    each = len(items) // len(groups)
    summaries = {}
    for k, (setting, name) in enumerate(groups):
        part = slice(k * each, (k + 1) * each)
        summaries[f"{name}, {setting} settings"] = summary(items[part], results[part])
    if o.json != "-":
        print(f"Sensor noise {o.sensor_noise} rad/s, torque disturbance {o.torque_disturbance} N.m a sample\n")
        print("\n".join(text_of(name, s) for name, s in summaries.items()), end="")
    sweeps.write_json(o.json, summaries)
    return 0


if __name__ == "__main__":
    sweeps.run_script(main)
