#!/usr/bin/python3
"""One self-contained HTML page of what `armukf diagnose` found.

    armukf diagnose RUN.csv --validate OTHER.csv --json found.json --rows found.csv
    report.py found.json found.csv -o report.html
"""

import argparse
import base64
import html
import io
import sys

import numpy as np
from matplotlib import mlab

import pages
import pictures
from pages import table
from pictures import plt
from plot import InputError, read_json, read_table
from style import BAND, ESTIMATE, MEASURED, TRUE, title_of

BEFORE, AFTER = TRUE, ESTIMATE
COLUMNS = ["t", "u", "y", "residual_before", "residual_after", "motor_angle"]
MOST_CANDIDATES = 12  # of a round, in the picture
MEASURES = {"fit_percent": "simulation fit, %", "mse": "simulation MSE, (rad/s)²",
            "one_step_rmse": "one step ahead, RMSE, rad/s",
            "log_likelihood": "log-likelihood of the innovations",
            "ljung_box_p": "whiteness of the innovations, Ljung-Box p"}
FREE_MEASURES = ("fit_percent", "mse")  # that a model with effects of the motor's angle has twice
# Over what an effect's torque is drawn: what it depends on.
OVER = {"gravity": "motor_angle", "torque_ripple": "motor_angle", "backlash": "twist_gear",
        "gear_hysteresis": "twist_gear", "arm_stiffness_cubic": "twist_arm",
        "arm_friction": "speed_arm", "gear_friction": "speed_gear", "flexible_mode": "t",
        "payload_change": "t", "thermal_friction": "t", "drive_lag": "u", "input_delay": "u",
        "torque_gain": "u", "gear_spring_curve": "twist_gear", "torque_curve": "u",
        "angle_curve": "motor_angle"}
LABELS = {"t": "time, s", "u": "torque u, N·m", "motor_angle": "motor angle, rad",
          "twist_gear": "gear twist, rad", "twist_arm": "arm twist, rad",
          "speed_motor": "motor speed, rad/s", "speed_gear": "gear speed, rad/s",
          "speed_arm": "arm speed, rad/s"}


def residuals(rows):
    figure, axes = pictures.stacked(2, sharex=True, sharey=True)
    few = pictures.thinned(rows)
    for axis, column, colour, name in ((axes[0], "residual_before", BEFORE, "before"),
                                       (axes[1], "residual_after", AFTER, "after")):
        rms = np.sqrt(np.nanmean(rows[column] ** 2))
        axis.plot(few["t"], few[column], color=colour, linewidth=0.6)
        axis.set_ylabel("residual, rad/s")
        axis.set_title(f"{name}: {rms:.3g} rad/s rms", fontsize=10)
    axes[1].set_xlabel("time, s")
    return figure


def spectra(rows):
    figure, (axis,) = pictures.stacked(1, height=3.5)
    rate = 1 / np.median(np.diff(rows["t"]))
    segment = min(len(rows), round(pictures.SEGMENT_S * rate))
    for column, colour, name in (("y", MEASURED, "measured speed"),
                                 ("residual_before", BEFORE, "residual before"),
                                 ("residual_after", AFTER, "residual after")):
        power, frequency = mlab.psd(np.nan_to_num(rows[column]), NFFT=segment, Fs=rate, detrend="mean",
                                    noverlap=segment // 2)
        axis.loglog(frequency[1:], np.sqrt(power[1:]), color=colour, linewidth=1.1, label=name)
    axis.set_xlabel("frequency, Hz")
    axis.set_ylabel("density, (rad/s)/√Hz")
    axis.legend(fontsize=8)
    return figure


def ranking(candidates):
    rounds = sorted({c["round"] for c in candidates})
    figure, axes = plt.subplots(1, len(rounds), figsize=(max(5, 3.6 * len(rounds)), 4), squeeze=False)
    for axis, number in zip(axes.flat, rounds):
        shown = sorted((c for c in candidates if c["round"] == number),
                       key=lambda c: c["help_percent"])[-MOST_CANDIDATES:]
        colours = [AFTER if c["accepted"] else BAND for c in shown]
        axis.barh([title_of(c) for c in shown], [c["help_percent"] for c in shown], color=colours)
        axis.tick_params(labelsize=7)
        axis.set_title(f"round {number}", fontsize=10)
        axis.set_xlabel("fall of the squared error\nof predictions, %", fontsize=8)
    return figure


def shapes(rows):
    columns = [c for c in rows.dtype.names if "_torque_at_" in c]
    columns = [c for c in columns if np.ptp(rows[c]) > 0]
    if not columns:
        return None
    figure, axes = pictures.stacked(len(columns), height=2.8)
    few = pictures.thinned(rows)
    for axis, column in zip(axes, columns):
        effect, mass = column.split("_torque_at_")
        over = next((v for k, v in OVER.items() if effect.startswith(k)), "speed_motor")
        axis.plot(few[over], few[column], "-" if over == "t" else ".", color=AFTER, markersize=2,
                  linewidth=0.6)
        if np.ptp(rows[column]) < 1e-6 * np.max(np.abs(rows[column])):  # a constant and its rounding
            axis.set_ylim(sorted((0, 1.5 * rows[column][0])))
        axis.set_xlabel(LABELS[over])
        axis.set_ylabel(f"torque at the {mass}, N·m")
        axis.set_title(effect, fontsize=10)
    return figure


def embedded(figure, caption):
    buffer = io.BytesIO()
    figure.tight_layout()
    figure.savefig(buffer, format="png", dpi=110)
    plt.close(figure)
    data = base64.b64encode(buffer.getvalue()).decode()
    return (f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,{data}">'
            f"<figcaption>{html.escape(caption)}</figcaption></figure>")


def figure_of(number):
    return "–" if number is None else f"{number:.6g}"


def measures(found):
    lines = []
    for record in ("estimation", "validation"):
        before, after = (found[when][record] for when in ("before", "after"))
        over = ", over the measured angle" if after.get("over_measured_angle") else ""
        for key, label in MEASURES.items():
            name = label + over * (key in FREE_MEASURES)
            lines.append((record, name, figure_of(before[key]), figure_of(after[key])))
        if over:
            lines += [(record, f"free {MEASURES[key]}", figure_of(before["free"][key]), figure_of(after["free"][key]))
                      for key in FREE_MEASURES]
    return table(("record", "", "before", "after"), lines)


def effects(found):
    if not found["effects"]:
        return "<p>No effect was accepted.</p>"
    lines = []
    for effect in found["effects"]:
        values = "; ".join(f"{name} = {p['value']:.4g} ± {p['sd']:.2g} {p['unit']}"
                           for name, p in effect["parameters"].items())
        lines.append((title_of(effect), values, f"{effect['mse_reduction_percent']:.1f} %",
                      f"{effect['p_value']:.2g}", ", ".join(effect["confused_with"]) or "–"))
    return table(("effect", "parameters", "validation error less by", "p", "not told apart from"), lines)


def page(found, rows):
    files = found["files"]
    left = "".join(f"<li>{html.escape(line)}</li>" for line in found["unexplained"])
    parts = [f"<h1>Diagnosis: {html.escape(found['verdict'])}</h1>",
             f"<p>Fitted to {html.escape(files['estimation'])}, judged on "
             f"{html.escape(files['validation'])}; {found['base_fit']['starts_agreeing']} of "
             f"{found['base_fit']['starts']} starts of the base fit agree; {found['seconds']:.1f} s.</p>",
             effects(found), measures(found),
             embedded(residuals(rows), "Residual of the simulation, validation record"),
             embedded(spectra(rows), "Its spectrum beside that of the measured speed")]
    if found["candidates"]:
        parts.append(embedded(ranking(found["candidates"]),
                              "Candidates by what one linearised step would gain; dark: accepted"))
    if (figure := shapes(rows)) is not None:
        parts.append(embedded(figure, "What each effect does, as a torque, over what it depends on"))
    parts.append(f"<h2>What is left</h2><ul>{left}</ul>" if left else
                 "<h2>What is left</h2><p>Nothing that stands out of the noise.</p>")
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("json")
    parser.add_argument("rows")
    parser.add_argument("-o", "--output", required=True)
    options = parser.parse_args()
    for key in ("verdict", "effects", "before", "after", "candidates", "files"):
        read_json(options.json, key)
    body = page(read_json(options.json), read_table(options.rows, COLUMNS))
    text = pages.page("armukf diagnosis", body)
    try:
        with open(options.output, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise InputError(f"{options.output}: {error.strerror}") from None


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
