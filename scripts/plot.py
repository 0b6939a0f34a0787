#!/usr/bin/python3
"""Pictures of what armukf writes, as PNG, SVG or PDF by the suffix of -o.

    plot.py parameters ROWS.csv -o FILE     trajectories of the unknown parameters with a 90 % band
    plot.py innovations ROWS.csv -o FILE    innovations within ±3 sd, and the running mean NIS

ROWS.csv is what `armukf estimate` prints. --truth draws the values that `armukf simulate` uses.
"""

import argparse
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from recursive_figures import TRUTH

UNITS = {"k_g1": "N·m/rad", "k_g3": "N·m/rad³", "k_a": "N·m/rad", "d_g": "N·m·s/rad", "d_a": "N·m·s/rad"}
ESTIMATE, TRUE, BAND = "#0072b2", "#d55e00", "#a6cee3"  # told apart by colour-blind eyes, too
MOST_POINTS = 1000  # more than a picture shows; keeps an SVG small
NOT_PARAMETERS = {"innovation", "twist_gear", "twist_arm", "speed_motor", "speed_gear", "speed_arm"}
NINETY_PERCENT = 1.645  # half-width of the interval, in standard deviations


def read_rows(path):
    try:
        rows = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise SystemExit(complain(f"{path}: {str(error).splitlines()[0]}")) from None
    if rows.dtype.names is None or "innovation_sd" not in rows.dtype.names:
        raise SystemExit(complain(f"{path}: is not what armukf estimate prints: no innovation_sd"))
    return rows


def complain(message):
    print(message, file=sys.stderr)
    return 2


def thinned(rows):
    return rows[:: max(1, len(rows) // MOST_POINTS)]


def parameters(rows, options):
    rows = thinned(rows)
    names = [n for n in rows.dtype.names if f"{n}_sd" in rows.dtype.names and n not in NOT_PARAMETERS]
    columns = 2
    lines = -(-len(names) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(10, 1.9 * lines), sharex=True, squeeze=False)
    for axis, name in zip(axes.flat, names):
        value, sd = rows[name], rows[f"{name}_sd"]
        axis.fill_between(rows["t"], value - NINETY_PERCENT * sd, value + NINETY_PERCENT * sd,
                          color=BAND, linewidth=0, label="90 % band")
        axis.plot(rows["t"], value, color=ESTIMATE, linewidth=1.2, label="estimate")
        if options.truth and name in TRUTH:
            axis.axhline(TRUTH[name], color=TRUE, linewidth=1.0, linestyle="--", label="truth")
        settled = slice(len(value) // 20, None)  # the first wide band would hide the rest
        low, high = np.min(value[settled]), np.max(value[settled])
        margin = 0.35 * (high - low) + 1e-9
        axis.set_ylim(max(0.0, low - margin), high + margin)
        axis.set_ylabel(f"{name}\n{UNITS.get(name, '–')}")
        axis.grid(alpha=0.3)
    for axis in axes.flat[len(names):]:
        axis.axis("off")
    axes.flat[0].legend(fontsize=8, loc="best")
    for column in range(columns):
        bottom = [a for a in axes[:, column] if a.has_data()][-1]
        bottom.set_xlabel("time, s")
        bottom.tick_params(labelbottom=True)
    return figure


def innovations(rows, _options):
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(10, 5), sharex=True)
    count = np.arange(1, len(rows) + 1)
    nis = np.nancumsum(rows["nis"]) / count
    few = thinned(rows)
    top.fill_between(few["t"], -3 * few["innovation_sd"], 3 * few["innovation_sd"], color=BAND,
                     linewidth=0, label="±3 sd")
    top.plot(few["t"], few["innovation"], ".", color=ESTIMATE, markersize=2, label="innovation")
    top.set_ylim(*(3.2 * np.median(few["innovation_sd"]) * np.array([-1, 1])))
    top.set_ylabel("innovation, rad/s")
    top.legend(fontsize=8)
    bottom.plot(few["t"], thinned(nis), color=ESTIMATE)
    bottom.axhline(1.0, color=TRUE, linestyle="--", linewidth=1.0)
    bottom.set_ylim(0, max(2.0, 1.1 * nis[-1]))
    bottom.set_ylabel("mean NIS so far")
    bottom.set_xlabel("time, s")
    for axis in (top, bottom):
        axis.grid(alpha=0.3)
    return figure


def main():
    pictures = {"parameters": parameters, "innovations": innovations}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("picture", choices=pictures)
    parser.add_argument("rows")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--truth", action="store_true")
    options = parser.parse_args()
    figure = pictures[options.picture](read_rows(options.rows), options)
    figure.tight_layout()
    plt.rcParams["svg.hashsalt"] = "armukf"  # the same picture is the same file
    figure.savefig(options.output, dpi=130, metadata={"Date": None} if options.output.endswith(".svg") else None)


if __name__ == "__main__":
    main()
