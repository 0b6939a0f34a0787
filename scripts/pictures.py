"""The pictures that plot.py draws: each takes the tables it shows and returns a figure."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from published import TRUTH
from style import BAND, BATCH, ESTIMATE, LAW_UNITS, MEASURED, NINETY_PERCENT, TRUE

UNITS = {"k_g1": "N·m/rad", "k_g3": "N·m/rad³", "k_a": "N·m/rad", "d_g": "N·m·s/rad",
         "d_a": "N·m·s/rad"}
MOST_POINTS = 2000  # more than a picture shows; keeps an SVG small
NOT_PARAMETERS = {"innovation", "twist_gear", "twist_arm", "speed_motor", "speed_gear", "speed_arm"}
ARM = {"Fv", "Fc", "Fcs", "alpha", "beta", "J", *TRUTH}  # before them stand states of effects
SEGMENT_S = 2.0  # s, of a record, averaged over for its frequency response
HIGHEST_HZ = 100.0


def thinned(rows):
    return rows[:: max(1, len(rows) // MOST_POINTS)]


def stacked(count, height=2.2, **options):
    figure, axes = plt.subplots(count, 1, figsize=(10, height * count), squeeze=False, **options)
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    return figure, list(axes.flat)


def records(tables, names):
    figure, axes = stacked(2 * len(tables), height=1.7)
    for table, name, (top, bottom) in zip(tables, names, zip(axes[::2], axes[1::2])):
        few = thinned(table)
        top.plot(few["t"], few["u"], color=TRUE, linewidth=0.7)
        top.set_ylabel("torque u, N·m")
        top.set_title(name, fontsize=10)
        bottom.plot(few["t"], few["y"], color=ESTIMATE, linewidth=0.7)
        bottom.set_ylabel("speed y, rad/s")
        bottom.set_xlabel("time, s")
    return figure


def fit_percent(table):
    ok = np.isfinite(table["residual"])
    spread = np.linalg.norm(table["y"][ok] - np.mean(table["y"][ok]))
    return 100 * (1 - np.linalg.norm(table["residual"][ok]) / spread)


def fit(tables, names):
    figure, axes = stacked(len(tables), sharex=True, height=2.8)
    for table, name, axis in zip(tables, names, axes):
        few = thinned(table)
        axis.plot(few["t"], few["y"], color=MEASURED, linewidth=0.8, label="measured")
        axis.plot(few["t"], few["y_hat"], color=ESTIMATE, linewidth=0.8, label="model")
        axis.set_ylabel("motor speed, rad/s")
        axis.set_title(f"{name}: fit {fit_percent(table):.2f} %", fontsize=10)
        axis.legend(fontsize=8, loc="upper right")
    axes[-1].set_xlabel("time, s")
    return figure


def errors(tables, names):
    figure, axes = stacked(len(tables), sharex=True, sharey=True)
    for table, name, axis in zip(tables, names, axes):
        few = thinned(table)
        rms = np.sqrt(np.nanmean(table["residual"] ** 2))
        axis.plot(few["t"], few["residual"], color=ESTIMATE, linewidth=0.6)
        axis.set_ylabel("error, rad/s")
        axis.set_title(f"{name}: {rms:.3g} rad/s rms", fontsize=10)
    axes[-1].set_xlabel("time, s")
    return figure


def names_of(rows):
    names = [n for n in rows.dtype.names if f"{n}_sd" in rows.dtype.names and n not in NOT_PARAMETERS]
    return names[next((k for k, name in enumerate(names) if name in ARM), 0):]


def parameters(rows, truth=False, batch=None):
    rows = thinned(rows)
    names = names_of(rows)
    columns = 2
    lines = -(-len(names) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(10, 1.9 * lines), sharex=True, squeeze=False)
    for axis, name in zip(axes.flat, names):
        trajectory(axis, rows, name, truth, batch)
    for axis in axes.flat[len(names):]:
        axis.axis("off")
    axes.flat[0].legend(fontsize=8, loc="best")
    for column in range(columns):
        bottom = [a for a in axes[:, column] if a.has_data()][-1]
        bottom.set_xlabel("time, s")
        bottom.tick_params(labelbottom=True)
    return figure


def trajectory(axis, rows, name, truth, batch, settles=0.05):
    """`settles`: the share of the rows in which the first wide band would hide the rest."""
    value, sd = rows[name], rows[f"{name}_sd"]
    axis.fill_between(rows["t"], value - NINETY_PERCENT * sd, value + NINETY_PERCENT * sd,
                      color=BAND, linewidth=0, label="90 % band")
    axis.plot(rows["t"], value, color=ESTIMATE, linewidth=1.2, label="recursive")
    settled = slice(int(len(value) * settles), None)
    shown = [np.min(value[settled]), np.max(value[settled])]
    if truth and name in TRUTH:
        axis.axhline(TRUTH[name], color=TRUE, linewidth=1.0, linestyle="--", label="truth")
        shown.append(TRUTH[name])
    if batch and name in batch:
        middle, half = batch[name]["value"], NINETY_PERCENT * batch[name]["sd"]
        axis.axhspan(middle - half, middle + half, color=BATCH, alpha=0.2, linewidth=0)
        axis.axhline(middle, color=BATCH, linewidth=1.0, label="batch, 90 % band")
        shown.append(middle)
    margin = 0.35 * (max(shown) - min(shown)) + 1e-9
    axis.set_ylim(max(0.0, min(shown) - margin), max(shown) + margin)
    axis.set_ylabel(f"{name}\n{UNITS.get(name, '–')}")
    axis.grid(alpha=0.3)


def event_text(event):
    text = f"{event['what']}: {event['from']:.4g} → {event['to']:.4g} ± {event['sd']:.2g}"
    return text + (f", or {', '.join(event['also_possible'])}" if event["also_possible"] else "")


def events(rows, found):
    """A line of its own for each event, from its onset until it was told; below, what the parameters did,
    with all onsets, and bold where it was this parameter; then what the watch looks at."""
    few = thinned(rows)
    names = names_of(rows)
    heights = [0.6 + 0.3 * max(1, len(found))] + [1.7] * (len(names) + 1)
    figure, axes = plt.subplots(len(heights), 1, figsize=(10, sum(heights)), sharex=True, squeeze=False,
                                gridspec_kw={"height_ratios": heights})
    timeline, *panels, bottom = axes.flat
    timeline.set_ylim(max(1, len(found)) - 0.5, -0.5)
    timeline.set_yticks([])
    timeline.set_ylabel("events")
    first, last = rows["t"][0], rows["t"][-1]
    for line, event in enumerate(found):
        onset, said = event["onset"], event["t"]
        timeline.plot([onset, said], [line, line], color=TRUE, linewidth=4, solid_capstyle="butt")
        left = onset - first > 0.5 * (last - first)
        timeline.annotate(event_text(event), (onset if left else said, line), (-6 if left else 6, 0),
                          textcoords="offset points", ha="right" if left else "left", va="center", fontsize=8)
    if not found:
        timeline.text(0.5, 0.5, "none", transform=timeline.transAxes, ha="center", va="center", fontsize=8)
    for axis, name in zip(panels, names):
        trajectory(axis, few, name, truth=False, batch=None, settles=0.2)
        for event in found:
            own = event["what"] == name
            axis.axvline(event["onset"], color=TRUE, linewidth=2.0 if own else 0.8, linestyle="-" if own else ":")
    panels[0].legend(fontsize=8, loc="best")
    running_nis(bottom, rows, 0.25)
    for event in found:
        bottom.axvline(event["onset"], color=TRUE, linewidth=0.8, linestyle=":")
    bottom.set_ylabel("NIS, mean\nover 0.25 s")
    bottom.set_xlabel("time, s")
    figure.align_ylabels()
    return figure


def laws(found):
    figure, axes = stacked(len(found), height=2.8)
    for axis, (name, law) in zip(axes, found.items()):
        at, value = np.array(law["at"]), np.array(law[law["quantity"]])
        half = NINETY_PERCENT * np.array(law["sd"], dtype=float)  # NaN where nothing is known
        axis.fill_between(at, value - half, value + half, color=BAND, linewidth=0,
                          label="90 % band")
        axis.plot(at, value, color=ESTIMATE, linewidth=1.2, label=name)
        axis.axhline(0.0, color=MEASURED, linewidth=0.6)
        axis.set_xlabel(f"{law['over']}, {law['unit']}")
        axis.set_ylabel(f"{law['quantity']}, {LAW_UNITS[law['quantity']]}")
        axis.set_title(law["gives"], fontsize=10)
        axis.legend(fontsize=8)
    return figure


def innovations(rows):
    figure, (top, bottom) = stacked(2, sharex=True, height=2.5)
    few = thinned(rows)
    mean = np.nancumsum(rows["nis"]) / np.arange(1, len(rows) + 1)
    top.fill_between(few["t"], -3 * few["innovation_sd"], 3 * few["innovation_sd"], color=BAND,
                     linewidth=0, label="±3 sd")
    top.plot(few["t"], few["innovation"], ".", color=ESTIMATE, markersize=2, label="innovation")
    top.set_ylim(*(3.2 * np.median(few["innovation_sd"]) * np.array([-1, 1])))
    top.set_ylabel("innovation, rad/s")
    top.legend(fontsize=8)
    bottom.plot(few["t"], thinned(mean), color=ESTIMATE)
    bottom.axhline(1.0, color=TRUE, linestyle="--", linewidth=1.0)
    bottom.set_ylim(0, max(2.0, 1.1 * mean[-1]))
    bottom.set_ylabel("mean NIS so far")
    bottom.set_xlabel("time, s")
    return figure


def nis(rows, window_s=0.25):
    figure, (axis,) = stacked(1, height=3.5)
    running_nis(axis, rows, window_s)
    axis.set_ylabel("normalised innovation squared")
    axis.set_xlabel("time, s")
    axis.legend(fontsize=8)
    return figure


def running_nis(axis, rows, window_s):
    from scipy import stats  # here, since all else does without: a report must be drawn without it

    window = max(1, round(window_s / np.median(np.diff(rows["t"]))))
    sums, counts = (np.convolve(values, np.ones(window), mode="same")
                    for values in (np.nan_to_num(rows["nis"]), np.ones(len(rows))))
    mean = sums / counts
    low, high = (stats.chi2.ppf(p, window) / window for p in (0.025, 0.975))
    axis.plot(thinned(rows)["t"], thinned(mean), color=ESTIMATE, linewidth=0.9,
              label=f"mean over {window_s:g} s")
    axis.axhspan(low, high, color=BAND, linewidth=0, label="95 % of an honest filter's")
    axis.axhline(1.0, color=TRUE, linestyle="--", linewidth=1.0)
    axis.set_yscale("log")
    axis.grid(alpha=0.3)


def correlation(residual, name):
    figure, axes = stacked(2, height=2.5)
    parts = (("autocorrelation", "autocorrelation_band_99", 1, "residual with itself"),
             ("input_crosscorrelation", "input_crosscorrelation_band_99", 0, "residual with the input"))
    for axis, (values, band, first, label) in zip(axes, parts):
        lags = np.arange(first, first + len(residual[values]))
        axis.axhspan(-residual[band], residual[band], color=BAND, linewidth=0, label="99 % band")
        axis.vlines(lags, 0, residual[values], color=ESTIMATE, linewidth=1.5)
        axis.plot(lags, residual[values], "o", color=ESTIMATE, markersize=4)
        axis.axhline(0, color=MEASURED, linewidth=0.8)
        axis.set_ylabel(f"correlation of\n{label}")
        axis.legend(fontsize=8, loc="upper right")
    axes[0].set_title(name, fontsize=10)
    axes[1].set_xlabel("lag, samples")
    return figure


def response(table, name):
    """Averaged cross spectra: |S_yu / S_uu| of the data, the model and the residual, and how much
    of the data is coherent with the torque."""
    from scipy import signal

    rate = 1 / np.median(np.diff(table["t"]))
    segment = min(len(table), round(SEGMENT_S * rate))
    options = {"fs": rate, "nperseg": segment, "detrend": "constant"}
    u = table["u"]
    figure, (top, bottom) = stacked(2, sharex=True, height=3)
    for column, label, colour in (("y", "data", MEASURED), ("y_hat", "model", ESTIMATE),
                                  ("residual", "residual", TRUE)):
        values = np.nan_to_num(table[column])
        frequency, cross = signal.csd(u, values, **options)
        _, power = signal.welch(u, **options)
        shown = (frequency > 0) & (frequency <= HIGHEST_HZ)
        gain = 20 * np.log10(np.abs(cross[shown] / power[shown]) + 1e-12)
        top.semilogx(frequency[shown], gain, color=colour, linewidth=1.2, label=label)
        if column != "y_hat":
            _, coherence = signal.coherence(u, values, **options)
            bottom.semilogx(frequency[shown], coherence[shown], color=colour, linewidth=1.2,
                            label=label)
    top.set_ylabel("torque → speed,\ndB of (rad/s)/(N·m)")
    top.set_title(name, fontsize=10)
    top.legend(fontsize=8)
    bottom.set_ylabel("coherence with the torque")
    bottom.set_ylim(0, 1.02)
    bottom.set_xlabel("frequency, Hz")
    bottom.legend(fontsize=8)
    return figure
