#!/usr/bin/python3
"""Recursive against batch, over many records, filters and start values.

    compare.py [RECORD...] [--seeds N] [--starts N] [--filters NAME...] [--picture FILE.png]

For each RECORD, or N simulated ones, the batch estimate (all initial states free) is the reference. Each
filter goes over the record once from the published start, and from random starts about it. The table
tells by how much the recursion differs in the end, how soon each parameter comes within 5 % of the batch
value and stays there, and how many runs come that far in all parameters; the picture, the median
distance over time, and how late.
"""

import argparse
import csv
import json
import math
import random
import statistics
import subprocess
import tempfile
from pathlib import Path

import sweeps
from sweeps import START, START_SPREAD, TRUTH, Trouble

NEAR = 0.05
GRID = [0.05 * k for k in range(1, 201)]  # s, at which the distance is told


def batch(item):
    """The batch estimate of a record, simulated or given."""
    with tempfile.TemporaryDirectory() as folder:
        result = sweeps.armukf(item["program"], "fit", record_of(item, folder), "--free-initial", "all")
    return {p: result["parameters"][p]["value"] for p in TRUTH} | {"fit": result["fit_percent"]}


def record_of(item, folder):
    if item.get("record"):
        return item["record"]
    return sweeps.simulate(item["program"], Path(folder, "record.csv"), item["seed"], item["noise"],
                           item["disturbance"])


def start_of(number):
    """Start values: 0 is the published start, others are drawn about it."""
    return {} if number == 0 else sweeps.drawn_about(START, START_SPREAD, random.Random(f"start {number}"))


def known(sd):
    """A deviation; null is one of which nothing is known."""
    return math.inf if sd is None else sd


def recursion(item):
    """Distance of each parameter from the batch value over time, and at the end."""
    with tempfile.TemporaryDirectory() as folder:
        words = [word for p, v in start_of(item["start"]).items() for word in ("--set", f"{p}={v!r}")]
        if item["model"]:
            words += ["--model", item["model"]]
        summary = Path(folder, "summary.json")
        done = subprocess.run([item["program"], "estimate", str(record_of(item, folder)), "--filter",
                               item["filter"], "--json", str(summary), "--quiet", *words],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Trouble(done.stderr.strip())
        result = json.loads(summary.read_text())
    rows = csv.reader(line for line in done.stdout.splitlines() if not line.startswith("#"))
    header = next(rows)
    columns = {p: header.index(p) for p in TRUTH}
    first, late, distance, grid = None, dict.fromkeys(TRUTH, 0.0), {p: [] for p in TRUTH}, iter(GRID)
    mark = next(grid)
    for row in rows:
        t = float(row[0])
        first = t if first is None else first
        off = {p: float(row[c]) / item["batch"][p] - 1 for p, c in columns.items()}
        for p, d in off.items():
            if not abs(d) <= NEAR:
                late[p] = t - first
        while mark is not None and t - first >= mark:
            for p, d in off.items():
                distance[p].append(abs(d))
            mark = next(grid, None)
    length = t - first
    return {"distance": distance, "settled_s": {p: v if v < 0.999 * length else None for p, v in late.items()},
            "difference": off, "fit": result["simulation"]["fit_percent"],
            "sd": {p: known(result["parameters"][p]["sd"]) / item["batch"][p] for p in TRUTH}}


def summary(results, batches):
    table = {}
    for p in TRUTH:
        settled = [r["settled_s"][p] for r in results]
        table[p] = {"median_difference_percent": 100 * statistics.median(abs(r["difference"][p]) for r in results),
                    "median_difference_sd": statistics.median(abs(r["difference"][p]) / r["sd"][p] for r in results),
                    "settled_percent": 100 * statistics.mean(s is not None for s in settled),
                    "median_settled_s": statistics.median(math.inf if s is None else s for s in settled)}
    near = [all(r["settled_s"][p] is not None for p in ("a_m", "a_g", "k_g1")) for r in results]
    return {"runs": len(results), "parameters": table, "stiffness_and_shares_settled_percent":
            100 * statistics.mean(near), "fit_percent": statistics.median(r["fit"] for r in results),
            "batch_fit_percent": statistics.median(b["fit"] for b in batches)}


def text_of(name, s):
    lines = [f"## {name}", "", f"{s['runs']} runs; simulation fit {s['fit_percent']:.2f} %, batch "
             f"{s['batch_fit_percent']:.2f} % (medians); a_m, a_g and k_g1 within 5 % and staying in "
             f"{s['stiffness_and_shares_settled_percent']:.0f} % of the runs", "",
             "| parameter | median difference % | in sd | within 5 % to stay, of runs % | from, median s |",
             "|---|---|---|---|---|"]
    for p, e in s["parameters"].items():
        when = f"{e['median_settled_s']:.2f}" if math.isfinite(e["median_settled_s"]) else "–"
        lines.append(f"| {p} | {e['median_difference_percent']:.2f} | {e['median_difference_sd']:.1f} "
                     f"| {e['settled_percent']:.0f} | {when} |")
    return "\n".join(lines) + "\n"


def draw(path, groups):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    figure, axes = plt.subplots(2, 4, figsize=(13, 6), sharex=True, constrained_layout=True)
    for axis, p in zip(axes.flat, TRUTH):
        for k, (name, results) in enumerate(groups.items()):
            length = min(len(r["distance"][p]) for r in results)
            distance = 100 * np.array([r["distance"][p][:length] for r in results])
            axis.semilogy(GRID[:length], np.median(distance, axis=0), color=f"C{k}", label=name)
            axis.fill_between(GRID[:length], *np.percentile(distance, [10, 90], axis=0), color=f"C{k}", alpha=0.15)
        axis.axhline(100 * NEAR, color="0.4", linestyle=":", linewidth=1)
        axis.set_title(p)
        axis.set_ylim(1e-2, 1e3)
        axis.grid(alpha=0.3)
    for axis in axes[1]:
        axis.set_xlabel("time (s)")
    for axis in axes[:, 0]:
        axis.set_ylabel("from batch (%)")
    axes[0, 3].set_xlabel("time (s)")
    axes[1, 3].axis("off")
    axes[1, 3].legend(*axes[0, 0].get_legend_handles_labels(), loc="center", frameon=False,
                      title="median, 10 to 90 % of the runs\n(dotted: 5 %)")
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="*", metavar="RECORD")
    parser.add_argument("--seeds", type=int, default=10, help="simulated records, where none is given")
    parser.add_argument("--starts", type=int, default=5, help="start values for each record")
    parser.add_argument("--filters", nargs="+", default=["ukf", "ekf"])
    parser.add_argument("--model", metavar="FILE.toml", help="settings of the filters")
    parser.add_argument("--sensor-noise", type=float, default=0.1, help="rad/s, of simulated records")
    parser.add_argument("--torque-disturbance", type=float, default=0.1, help="N.m, held per sample")
    parser.add_argument("--picture", metavar="FILE")
    sweeps.add_options(parser)
    o = parser.parse_args()
    for record in o.records:
        if not Path(record).is_file():
            raise Trouble(f"{record}: no such file")
    common = {"program": str(Path(o.program).resolve()), "noise": o.sensor_noise,
              "disturbance": o.torque_disturbance}
    records = ([{**common, "record": str(Path(r).resolve())} for r in o.records] or
               [{**common, "seed": s} for s in range(1, o.seeds + 1)])
    model = str(Path(o.model).resolve()) if o.model else ""
    with sweeps.pool(o.workers, o.scheduler) as pool:
        ledger = sweeps.Ledger(o.state)
        batches = pool.map(batch, records, ledger, "batch estimates")
        groups = {}
        for name in o.filters:
            items = [{**r, "batch": {p: b[p] for p in TRUTH}, "filter": name, "start": start, "model": model}
                     for r, b in zip(records, batches) for start in range(o.starts)]
            groups[name] = pool.map(recursion, items, ledger, name)
    summaries = {name: summary(results, batches) for name, results in groups.items()}
    if o.json != "-":
        print("\n".join(text_of(name, s) for name, s in summaries.items()), end="")
    if o.picture:
        draw(o.picture, groups)
    sweeps.write_json(o.json, summaries)
    return 0


if __name__ == "__main__":
    sweeps.run_script(main)
