"""What a diagnosis says, in plain words."""

from math import floor, isfinite, log10, sqrt

from pages import counted
from style import title_of

# Effects and learnt laws, as one would tell a colleague.
PLAIN = {
    "torque_bias": "a constant torque beside the commanded one",
    "torque_gain": "a motor that gives more or less torque than commanded",
    "torque_ripple_commanded": "a torque constant that goes with the motor's angle",
    "torque_ripple": "a torque that goes with the motor's angle",
    "input_delay": "a torque that arrives late",
    "drive_lag": "a drive that gives the torque late",
    "drive_lag_second_order": "a drive that gives the torque late, with an oscillation of its own",
    "friction_parameters": "motor friction that is no longer what was identified",
    "coulomb_asymmetry": "dry friction that differs between the directions",
    "gear_friction": "friction in the gear box",
    "arm_friction": "friction at the arm",
    "load_dependent_friction": "friction that grows with the load of the gear",
    "thermal_friction": "friction that changes while the motor warms up",
    "thermal_friction_cold": "friction of an arm that begins colder than the one whose friction is known",
    "thermal_friction_heated": "friction that changes with the heat that it makes",
    "presliding_friction": "dry friction that bends before it slides",
    "presliding_friction_lugre": "known dry friction that bends before it slides",
    "backlash": "play in the gear",
    "gear_hysteresis": "dry friction inside the gear's spring",
    "gear_damping_quadratic": "gear damping that grows with the rate of the twist",
    "arm_stiffness_cubic": "an arm spring that hardens",
    "flexible_mode": "a mass that swings on a spring of its own",
    "gravity": "the arm's weight",
    "payload_change": "a payload that changes",
    "sensor_lag": "a speed sensor that tells late",
    "speed_ripple": "a speed sensor that errs with the motor's angle",
    "speed_ripple_constant": "a speed sensor that errs with the motor's angle, as much at any speed",
    "external_torque": "a torque from outside at a frequency of its own",
    "friction_change": "dry friction that becomes another",
    "friction_ripple": "dry friction that goes with the motor's angle",
    "thermal_torque": "a torque constant that changes while the motor warms up",
    "thermal_torque_heated": "a torque constant that changes with the heat that the motor makes",
    "thermal_damping": "gear damping that changes while the grease warms up",
    "gear_stiffness_ripple": "a gear whose stiffness goes with the motor's angle",
    "transmission_error": "a gear that does not turn quite as its motor",
    "pose_inertia": "an arm whose inertia goes with its pose",
    "arm_hysteresis": "dry friction inside the arm's spring",
    "arm_backlash": "play where the arm is joined to the gear box",
    "sensor_coupling": "a speed sensor on a coupling that swings",
    "gear_stiffness_change": "a gear whose stiffness becomes another",
    "arm_stiffness_change": "an arm spring whose stiffness becomes another",
    "gear_slip": "a gear that slips under load",
    "gear_relaxation": "a gear that is stiffer in quick motion than in slow",
    "torque_limit": "a drive that gives no more than its limit",
    "torque_slew": "a drive whose torque rises and falls no faster than its limit",
    "friction_lag": "friction that weakens late",
    "drive_notch": "a notch in the drive's torque",
    "sensor_gain": "a speed sensor whose scale is off",
    "sensor_curve": "a speed sensor whose scale changes with the speed, by a law without a name",
    "friction_curve": "friction over speed that no named law tells",
    "gear_spring_curve": "a gear spring that no named law tells",
    "arm_spring_curve": "an arm spring that no named law tells",
    "torque_curve": "a drive whose torque is not the commanded one, by a law without a name",
    "angle_curve": "a torque over the motor's angle that no single harmonic tells"}
FEW = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
WHITE_P = 0.01


def in_words(number):
    return FEW[number] if number < len(FEW) else str(number)


def listed(parts):
    *most, last = parts
    return ", ".join(most) + (" and " if most else "") + last


def figure(value, digits=3):
    """That many digits, zeros at the end as well."""
    if value is None or not isfinite(value):
        return "–"
    if value == 0:
        return "0"
    if 1e-4 <= abs(value) < 10 ** digits:
        return f"{value:#.{digits}g}".rstrip(".")
    return f"{value:.0f}" if 1 <= abs(value) < 1e6 else f"{value:.{digits}g}"


def unit_text(unit):
    return "" if unit == "-" else unit.replace(".", "·").replace("^2", "²").replace("^3", "³")


def with_deviation(value, sd, unit=""):
    """As many digits as the deviation has two of."""
    if value is None:
        return "–"
    if not sd or not isfinite(sd):
        text = f"{value:.5g}"
    elif not 1e-7 <= sd < 1e5 or abs(value) >= 1e7:
        text = f"{value:.4e} ± {sd:.1e}"
    else:
        digits = max(0, 1 - floor(log10(sd)))
        text = f"{value:.{digits}f} ± {sd:.{digits}f}"
    return f"{text} {unit_text(unit)}".strip()


def effect_text(effect):
    name, (size, *_) = title_of(effect), list(effect["parameters"].values()) or [None]
    told = PLAIN.get(effect["name"].partition(":")[0])
    inside = name + (f", {with_deviation(size['value'], size['sd'], size['unit'])}" if size else "")
    return f"{told} ({inside})" if told else f"{name}{inside[len(name):]}"


def chance_text(p):
    for bound, words in ((1e-6, "less than one in a million"), (1e-3, "less than one in a thousand")):
        if p < bound:
            return words
    return f"{100 * p:.2g} %"


def nearest_of(candidates):
    """Of those that were refused, what chance explains least."""
    refused = [c for c in candidates if not c["accepted"] and c.get("refused_because")]
    return min(refused, key=lambda c: (c["p_value"], -c["help_percent"]), default=None)


def missing(found):
    effects, tried = found["effects"], len({title_of(c) for c in found.get("candidates", [])})
    if effects:
        count = in_words(len(effects)).capitalize()
        told = f"{count} effect{' is' if len(effects) == 1 else 's are'} missing from the model: " + \
            listed([effect_text(e) for e in effects]) + "."
        return told + (" Something else is left that none explains." if found["unexplained"] else "")
    if found["verdict"] == "model sufficient":
        return f"Nothing that these records could show. {tried} effects were tried, and none explains more than chance."
    return f"Something is, but it has no name: {tried} effects were tried, and none counts as found."


def sure(found):
    parts, effects = [], found["effects"]
    if effects:
        worst = max(e["p_value"] for e in effects)
        each = "it" if len(effects) == 1 else "each of them"
        parts.append(f"Were {each} not there, noise would look like it with a chance of {chance_text(worst)}, "
                     "counting all that was tried.")
    elif nearest := nearest_of(found["candidates"]):
        parts.append(f"What came nearest, {title_of(nearest)}, was refused: {nearest['refused_because']}.")
    own = found["files"]["validation"].startswith("blocks")
    parts.append("Judged on blocks of the record, each by a fit that had not seen it." if own else
                 f"Judged on {found['files']['validation']}, to which nothing was fitted.")
    if found["files"].get("values_fitted_to") == "estimation and validation":
        parts.append("After that, its values were fitted to all records together.")
    if other := found["files"].get("shows_nothing"):
        parts.append(f"{other} does not excite it, and is foretold as well with it as without.")
    base = found.get("base_fit")
    if base and base["starts_agreeing"] < 2:
        parts.append(f"But the {base['starts']} starts of the first fit end apart: this may trace a poor fit.")
    parts += [f"These records cannot tell {e['name']} from {listed(e['confused_with'])}."
              for e in effects if e["confused_with"]]
    return " ".join(parts)


def rms_of(measures):
    return sqrt(measures["mse"]) if measures["mse"] is not None else float("nan")


def percent(value):
    return "–" if value is None else f"{value:.4g} %"


def better(found):
    before, after = found["before"]["validation"], found["after"]["validation"]
    angle = " over the measured angle" if after.get("over_measured_angle") else ""
    if not found["effects"]:
        return (f"Simulated{angle}, the model as it is misses the measured speed by {figure(rms_of(before))} rad/s "
                f"rms: a fit of {percent(before['fit_percent'])}.")
    less = 100 * (1 - after["mse"] / before["mse"]) if after["mse"] is not None and before["mse"] else float("nan")
    change = f"{less:.3g} % less" if less >= 0 else f"{-less:.3g} % more"
    text = (f"Simulated{angle}, the model missed the measured speed by {figure(rms_of(before))} rad/s rms; "
            f"completed, by {figure(rms_of(after))} ({change} squared error). The fit goes from "
            f"{percent(before['fit_percent'])} to {percent(after['fit_percent'])}.")
    if angle:
        free = [figure(rms_of(side["free"])) for side in (before, after)]
        text += f" Simulated freely, its own angle drifting, by {free[1]} instead of {free[0]} rad/s."
    white = after["ljung_box_p"]
    return text if white is None else text + (
        " What is left of predictions one sample ahead looks like noise." if white >= WHITE_P else
        " What is left of predictions one sample ahead is not just noise: the model is still no complete one.")


def next_step(found):
    parts = []
    tells = list(dict.fromkeys(text for e in found["effects"] for text in e.get("told_apart_by", [])))
    if found["effects"]:
        parts.append("Go on with the completed model: `armukf diagnose --save COMPLETED.toml` writes it, and every "
                     "command takes it by `--model COMPLETED.toml`.")
    if tells:
        parts.append(f"To tell apart what these records cannot, record {', or '.join(tells)}.")
    if found["unexplained"]:
        parts.append("Look at what is left, below: its shape over speed, angle and frequency says where to search, "
                     "and a record that excites just that says more.")
    if not parts:
        parts.append("Use the model as it is. A record of other motion, slower, longer or with reversals, may show "
                     "what these cannot.")
    return " ".join(parts)


def lead(found):
    """[(question, answer)]"""
    return [("What is missing?", missing(found)), ("How sure is that?", sure(found)),
            ("How much better?" if found["effects"] else "How good is it?", better(found)),
            ("What next?", next_step(found))]


def title(found):
    names = [title_of(e) for e in found["effects"]]
    return {"model sufficient": "Nothing is missing",
            "residual unexplained": "Something is missing that has no name"}.get(
        found["verdict"], f"Missing: {listed(names)}" if names else found["verdict"])


def starts_text(found):
    base = found.get("base_fit")
    return f"{base['starts_agreeing']} of {counted(base['starts'], 'start')} of the first fit agree" if base else ""
