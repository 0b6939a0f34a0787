"""The charts of a diagnosis, for report_page/charts.js to draw.

A chart is {"id", "title", "about", "with", "views"}: those of the same "with" are zoomed together. A view is
{"name", "x", "y", "at", "lines", "bands", "counts"}: axes {"name", "unit", "log"}, numbers along x, lines {"name",
"colour", "values", "note"}, bands between lines [upper, lower, colour], and how many samples stand behind each
number. A string in place of numbers names one of the columns that charts share.
"""

import numpy as np

from report_words import figure, unit_text
from style import LAW_UNITS, NINETY_PERCENT

MOST_ROWS = 20000   # of a record that a page holds; ten seconds at 2 kHz in full
BINS = 60           # of an angle or a speed
SHAPE_BINS = 120    # of what an effect depends on
FEWEST = 10         # samples, for a number to be told of them
SEGMENT_S = 2.0     # s, of a record, averaged over for its spectrum
GAP = 5.0           # usual intervals, that are a gap
PAUSE = 0.02        # of all, between records that are shown one after another
BANDS_HZ = (0, 1, 3, 10, 30, 100, 300, 1000, 3000, 10000)
TURN = 2 * np.pi    # rad
COLUMNS = ("y", "residual_before", "residual_after")

AXES = {"t": ("time", "s"), "u": ("torque u", "N·m"), "motor_angle": ("motor angle", "rad"),
        "twist_gear": ("gear twist", "rad"), "twist_arm": ("arm twist", "rad"), "speed_motor": ("motor speed", "rad/s"),
        "speed_gear": ("gear speed", "rad/s"), "speed_arm": ("arm speed", "rad/s")}
# What an effect's torque depends on.
OVER = {"gravity": "motor_angle", "torque_ripple": "motor_angle",
        "torque_ripple_commanded": "motor_angle", "backlash": "twist_gear",
        "gear_hysteresis": "twist_gear", "arm_stiffness_cubic": "twist_arm", "arm_friction": "speed_arm",
        "gear_friction": "speed_gear", "flexible_mode": "t", "payload_change": "t", "thermal_friction": "t",
        "drive_lag": "u", "drive_lag_second_order": "u", "input_delay": "u", "torque_gain": "u",
        "gear_spring_curve": "twist_gear", "arm_spring_curve": "twist_arm", "torque_curve": "u",
        "angle_curve": "motor_angle", "gear_slip": "twist_gear", "gear_relaxation": "twist_gear", "torque_limit": "u", "torque_slew": "u", "friction_lag": "speed_motor",
        "drive_notch": "u", "gear_stiffness_change": "t", "arm_stiffness_change": "t",
        "arm_backlash": "twist_arm", "arm_hysteresis": "twist_arm", "friction_change": "t", "friction_ripple": "motor_angle", "external_torque": "t",
        "thermal_torque": "t", "thermal_damping": "t", "gear_stiffness_ripple": "motor_angle",
        "transmission_error": "motor_angle", "thermal_torque_heated": "t",
        "pose_inertia": "motor_angle"}


def axis(name, unit, log=False):
    return {"name": name, "unit": unit, "log": log}


def line(name, colour, values, note=""):
    return {"name": name, "colour": colour, "values": values, "note": note}


def numbers(values, digits=5):
    """For JSON: that many digits, and None for what is not finite."""
    return [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in np.asarray(values, dtype=float)]


def rms(values):
    values = values[np.isfinite(values)]
    return np.sqrt(np.mean(values ** 2)) if len(values) else np.nan


def rms_note(values):
    return f"{figure(rms(values))} rad/s rms"


class Judged:
    """The rows of `armukf diagnose --rows`: pieces of records that judge, one after another."""

    def __init__(self, rows):
        self.rows = rows
        steps = np.diff(rows["t"])
        self.step = np.median(steps[steps > 0]) if np.any(steps > 0) else 1.0  # s
        self.records = 1 + int(np.sum(steps <= 0))
        cuts = np.flatnonzero((steps <= 0) | (steps > GAP * self.step)) + 1
        self.pieces = [slice(a, b) for a, b in zip([0, *cuts], [*cuts, len(rows)])]
        self.completed = not np.array_equal(rows["residual_before"], rows["residual_after"], equal_nan=True)
        self.t = self.one_after_another(steps)

    def one_after_another(self, steps):
        """s, that never goes back: where another record begins, it is shown behind the one before."""
        t = np.array(self.rows["t"], dtype=float)
        pause = PAUSE * np.sum(steps[steps > 0])
        for at in np.flatnonzero(steps <= 0) + 1:
            t[at:] += t[at - 1] + pause - t[at]
        return t

    def has(self, *names):
        return all(name in self.rows.dtype.names and np.any(np.isfinite(self.rows[name])) for name in names)

    def __getitem__(self, name):
        return self.t if name == "t" else np.asarray(self.rows[name], dtype=float)


def telling(judged, most=MOST_ROWS):
    """Places of the rows to be shown: all of them or, of each of many equal stretches, those where a column is least
    and where it is greatest. So every extreme stays, at its own time."""
    count = len(judged.rows)
    if count <= most:
        return np.arange(count)
    kept = {0, count - 1}
    for stretch in np.array_split(np.arange(count), most // (2 * len(COLUMNS))):
        for name in COLUMNS:
            values = judged[name][stretch]
            if np.any(np.isfinite(values)):
                kept.update((stretch[np.nanargmin(values)], stretch[np.nanargmax(values)]))
    return np.array(sorted(kept))


def shared_columns(judged):
    """Time, measured speed, residuals, and the speed that the completed model gives; a row without numbers where a
    piece ends."""
    kept = telling(judged)
    cuts = np.searchsorted(kept, [piece.start for piece in judged.pieces[1:]])
    columns = {"t": numbers(np.insert(judged.t[kept], cuts, judged.t[kept[cuts - 1]] + 0.5 * judged.step), 9)}
    for name in COLUMNS:
        columns[name] = numbers(np.insert(judged[name][kept], cuts, np.nan))
    model = (judged["y"] - judged["residual_after"])[kept]
    return {**columns, "model": numbers(np.insert(model, cuts, np.nan))}


def named(judged, lines):
    """There is no before and after where nothing was added."""
    return lines if judged.completed else [{**own, "name": "the model"} for own in lines if own["colour"] != "before"]


def over_time(judged):
    time, speed = axis("time", "s"), axis("motor speed", "rad/s")
    kept = "" if len(judged.rows) <= MOST_ROWS else "; least and greatest of each stretch"
    residuals = [line(when, when, f"residual_{when}", rms_note(judged[f"residual_{when}"]))
                 for when in ("before", "after")]
    model = "by the completed model" if judged.completed else "by the model"
    behind = "" if judged.records == 1 else f"; {judged.records} records, one behind another"
    return [
        {"id": "residual", "title": "What the simulation misses", "about": "measured less simulated" + kept + behind,
         "with": "time", "views": [{"name": "", "x": time, "y": axis("residual", "rad/s"), "at": "t",
                                    "lines": named(judged, residuals)}]},
        {"id": "speed", "title": "Measured and simulated", "about": model + kept, "with": "time",
         "views": [{"name": "", "x": time, "y": speed, "at": "t", "lines": [
             line("measured", "measured", "y"), line("simulated", "after", "model")]}]}]


def density(judged, name):
    """Hz, (rad/s)²/Hz: averaged over stretches of the pieces, half over half. A missing sample counts as 0."""
    length = min(round(SEGMENT_S / judged.step), max(p.stop - p.start for p in judged.pieces))
    window = np.hanning(length + 1)[:-1] if length > 2 else np.ones(length)
    values, total, count = judged[name], 0.0, 0
    for piece in judged.pieces:
        for begin in range(piece.start, piece.stop - length + 1, max(1, length // 2)):
            stretch = values[begin:begin + length]
            if not np.any(np.isfinite(stretch)):
                continue
            stretch = np.nan_to_num(stretch - np.nanmean(stretch))
            total = total + np.abs(np.fft.rfft(window * stretch)) ** 2
            count += 1
    hertz = np.fft.rfftfreq(length, judged.step)
    if count == 0:
        return hertz, np.full(len(hertz), np.nan)
    power = 2 * total * judged.step / (count * np.sum(window ** 2))
    return hertz, power


def by_band(judged):
    """[(from Hz, to Hz, rad/s rms before, after)]; the slowest holds all that the others do not, drift and offset."""
    names = ("residual_before", "residual_after")
    hertz, powers = density(judged, names[0])[0], [density(judged, name)[1] for name in names]
    top, bands = float(f"{hertz[-1]:.4g}"), []
    left = [np.nanmean(judged[name] ** 2) for name in names]
    for low, high in reversed([edges for edges in zip(BANDS_HZ, BANDS_HZ[1:]) if edges[0] < top]):
        inside = (hertz > low) & ((hertz <= high) | (high >= top))
        shares = [np.sum(p[inside]) * hertz[1] for p in powers] if low > 0 else [max(0.0, rest) for rest in left]
        left = [rest - share for rest, share in zip(left, shares)]
        bands.append((low, min(high, top), *np.sqrt(shares)))
    return bands[::-1]


def thirds(hertz, power):
    """Densities averaged over twelfths of a decade where lines are denser: a picture shows no more."""
    edges = 10 ** np.arange(np.log10(hertz[1]), np.log10(hertz[-1]) + 1e-9, 1 / 40)
    place = np.digitize(hertz[1:], edges)
    at = [np.mean(hertz[1:][place == k]) for k in np.unique(place)]
    return at, [np.mean(power[1:][place == k]) for k in np.unique(place)]


def spectrum(judged):
    lines = []
    for column, colour, name in (("y", "measured", "measured speed"), ("residual_before", "before", "residual before"),
                                 ("residual_after", "after", "residual after")):
        at, power = thirds(*density(judged, column))
        lines.append(line(name, colour, numbers(np.sqrt(power))))
    if not judged.completed:
        lines = [lines[0], {**lines[2], "name": "residual"}]
    return {"id": "band", "title": "By frequency", "about": "amplitude density", "views": [{
        "name": "", "x": axis("frequency", "Hz", True), "y": axis("density", "(rad/s)/√Hz", True), "at": numbers(at),
        "lines": lines}]}


def binned(over, values, bins):
    """Middles of equal bins, and of the values in each: count, mean, rms, least, greatest."""
    known = np.isfinite(over) & np.isfinite(values)
    over, values = over[known], values[known]
    if not len(over) or np.ptp(over) == 0:
        return None
    edges = np.linspace(np.min(over), np.max(over), bins + 1)
    place = np.clip(np.digitize(over, edges) - 1, 0, bins - 1)
    count = np.bincount(place, minlength=bins)
    enough = np.where(count >= FEWEST, count, np.nan)
    mean = np.bincount(place, values, minlength=bins) / enough
    square = np.bincount(place, values ** 2, minlength=bins) / enough
    least, greatest = np.full(bins, np.nan), np.full(bins, np.nan)
    np.fmin.at(least, place, values)
    np.fmax.at(greatest, place, values)
    thin = np.isnan(enough)
    least[thin] = greatest[thin] = np.nan
    return {"at": (edges[:-1] + edges[1:]) / 2, "count": count, "mean": mean, "rms": np.sqrt(square), "least": least,
            "greatest": greatest}


def residual_over(judged, chart, title, views):
    """Mean and rms of the residual in bins of what each view (name, axis, quantity) is over."""
    made = []
    for over_name, along, over in views:
        before, after = (binned(over, judged[f"residual_{when}"], BINS) for when in ("before", "after"))
        if before is None or after is None:
            continue
        for measure in ("mean", "rms"):
            made.append({"name": f"{measure}{over_name}", "x": along, "y": axis(f"{measure} residual", "rad/s"),
                         "at": numbers(before["at"]), "counts": before["count"].tolist(),
                         "lines": named(judged, [line("before", "before", numbers(before[measure])),
                                                 line("after", "after", numbers(after[measure]))])})
    about = "a mean that is not 0 has a law; grey: where the samples are"
    return {"id": chart, "title": title, "about": about, "views": made} if made else None


def by_angle(judged):
    if not judged.has("motor_angle"):
        return None
    angle = judged["motor_angle"]
    return residual_over(judged, "angle", "By the motor's angle", [
        ("", axis("motor angle", "rad"), angle), (" in a turn", axis("motor angle in a turn", "rad"), angle % TURN)])


def by_speed(judged):
    name = "speed_motor" if judged.has("speed_motor") else "y"  # the model's own has no noise
    return residual_over(judged, "by_speed", "By the motor's speed", [
        ("", axis("motor speed", "rad/s"), judged[name])])


def shape(over, name, unit, values, mass):
    torque = binned(over, values, SHAPE_BINS)
    if torque is None:
        return None
    return {"name": name, "x": axis(name, unit), "y": axis(f"torque at the {mass}", "N·m"),
            "at": numbers(torque["at"]), "counts": torque["count"].tolist(),
            "lines": [line("greatest", "fill", numbers(torque["greatest"])),
                      line("least", "fill", numbers(torque["least"])),
                      line("mean", "after", numbers(torque["mean"]))],
            "bands": [[0, 1, "fill"]]}


def column_name(effect):
    """How the rows call an effect; NumPy takes the colon out."""
    return "_".join([effect["name"]] + ([effect["site"]] if "site" in effect else [])).replace(":", "")


def over_of(name):
    """The column that an effect depends on."""
    return next((v for k, v in OVER.items() if name.startswith(k)), "speed_motor")


def learnt(law, over):
    """The curve of a learnt law with its 90 % band, and how many samples were near each of its points."""
    quantity = law["quantity"]
    at, value, sd = (np.array(law[key], dtype=float) for key in ("at", quantity, "sd"))  # a deviation of null: NaN
    half = NINETY_PERCENT * sd
    middles = (at[:-1] + at[1:]) / 2
    count = np.bincount(np.searchsorted(middles, over[np.isfinite(over)]), minlength=len(at))
    return {"name": "the law learnt", "x": axis(law["over"], unit_text(law["unit"])),
            "y": axis(quantity, LAW_UNITS[quantity]), "at": numbers(at), "counts": count.tolist(),
            "lines": [line("90 % band, upper end", "fill", numbers(value + half)),
                      line("lower end", "fill", numbers(value - half)),
                      line("the law", "after", numbers(value))],
            "bands": [[0, 1, "fill"]]}


def shape_of(effect, judged, laws):
    """What an effect does, over what it depends on, and over other quantities to choose from; None where the rows hold
    no torque of it, and no law is learnt."""
    name = column_name(effect)
    law = laws.get(effect["name"])
    first = over_of(name)
    learnt_views = [learnt(law, judged[first])] if law and judged.has(first) else []
    column = next((c for c in judged.rows.dtype.names if c.startswith(name + "_torque_at_")), None)
    if column is None or not np.any(np.nan_to_num(judged[column])):
        return {"id": "shape_" + name, "title": law["gives"], "about": "grey: where the samples are",
                "views": learnt_views} if learnt_views else None
    mass, torque = column.rpartition("_")[2], judged[column]
    views = [shape(judged[over], *AXES[over], torque, mass) for over in [first] + [k for k in AXES if k != first]
             if over == "t" or judged.has(over)]
    harmonic = next((p["value"] for k, p in effect["parameters"].items() if "_harmonic" in k), None)
    if harmonic and judged.has("motor_angle"):
        period = judged["motor_angle"] % (TURN / harmonic)
        views.insert(0, shape(period, "angle in its period", "rad", torque, mass))
    views = learnt_views + views
    return {"id": "shape_" + name, "title": f"Torque at the {mass}", "about": "grey: where the samples are",
            "views": [view for view in views if view]}
