"""A diagnosis that nobody has made: what `armukf diagnose --json --rows` would write of an arm with play in its gear
and weight at its arm."""

import json

import numpy as np

STEP = 0.0005  # s
COLUMNS = ["t", "u", "y", "residual_before", "residual_after", "motor_angle", "twist_gear", "twist_arm", "speed_motor",
           "speed_gear", "speed_arm", "backlash_torque_at_gear", "gravity_torque_at_arm"]


def measures(mse):
    return {"fit_percent": 100 * (1 - mse ** 0.5 / 20), "mse": mse, "one_step_rmse": 0.101, "log_likelihood": 7e3,
            "ljung_box_p": 0.25, "over_measured_angle": False}


def found():
    sides = {"estimation": measures(0.25), "validation": measures(0.16)}
    effects = [
        {"name": "backlash", "parameters": {"backlash": {"value": 0.01, "sd": 0.0002, "unit": "rad", "known": False}},
         "p_value": 1e-12, "mse_reduction_percent": 80.0, "confused_with": [], "told_apart_by": []},
        {"name": "gravity", "parameters": {"gravity": {"value": 1.5, "sd": 0.25, "unit": "N.m", "known": False}},
         "p_value": 2e-5, "mse_reduction_percent": 20.0, "confused_with": ["torque_bias"],
         "told_apart_by": ["slow motion over the whole range of the joint"]}]
    refused = {"accepted": False, "statistic": 2.5, "p_value": 1.0}
    candidates = [
        {"name": "backlash", "round": 1, "help_percent": 80.0, "statistic": 900.0, "p_value": 1e-12, "accepted": True},
        {"name": "flexible_mode", "site": "gear", "round": 1, "help_percent": 12.5, **refused,
         "refused_because": "its size may be chance: p 1, given all that was looked at"},
        {"name": "drive_lag", "round": 1, "help_percent": 0.0, **refused,
         "refused_because": "lowers the error of predictions less than others, or hardly at all"},
        {"name": "gravity", "round": 2, "help_percent": 20.0, "statistic": 80.0, "p_value": 2e-5, "accepted": True},
        {"name": "torque_bias", "round": 2, "help_percent": 18.0, **refused,
         "refused_because": "another explains more"}]
    parameters = {
        "a_m": {"unit": "", "before": 0.26, "before_sd": 0.01, "after": 0.266, "after_sd": 0.0003},
        "k_a": {"unit": "N.m/rad", "before": 10.5, "before_sd": 0.5, "after": 11.75, "after_sd": 0.03},
        "Fc": {"unit": "N.m", "before": 0.75, "before_sd": None, "after": 0.8, "after_sd": 0.02},
        "backlash": {"unit": "rad", "before": None, "before_sd": None, "after": 0.01, "after_sd": 0.0002}}
    return {"files": {"estimation": "first.csv", "validation": "second.csv"},
            "base_fit": {"starts": 4, "starts_agreeing": 3},
            "before": sides, "after": {"estimation": measures(0.05), "validation": measures(0.01)},
            "effects": effects, "candidates": candidates, "parameters": parameters,
            "consistency": [{"parameter": "k_a", "between": "halves", "values": [11.7, 11.8], "sd": [0.05, 0.06],
                             "p_value": 0.2}],
            "verdict": "effect found", "unexplained": [], "seconds": 12.5}


def rows(count=4000):
    noise = np.random.default_rng(5)
    made = np.zeros(count, dtype=[(name, float) for name in COLUMNS])
    t = made["t"] = STEP * np.arange(count)
    made["speed_motor"] = 20 * np.sin(2 * np.pi * 0.5 * t) + 5 * np.sin(2 * np.pi * 7 * t)
    made["motor_angle"] = STEP * np.cumsum(made["speed_motor"])
    made["twist_gear"] = 0.1 * np.sin(2 * np.pi * 7 * t)
    made["u"] = 10 * np.cos(2 * np.pi * 0.5 * t)
    made["residual_after"] = 0.1 * noise.standard_normal(count)
    made["residual_before"] = made["residual_after"] + 0.5 * np.sin(2 * np.pi * 20 * t)
    made["y"] = made["speed_motor"] + made["residual_after"]
    made["backlash_torque_at_gear"] = 0.2 * np.tanh(made["twist_gear"] / 0.02)
    made["gravity_torque_at_arm"] = 1.5 * np.sin(made["motor_angle"])
    return made


def write(folder, diagnosis, table):
    """found.json and found.csv."""
    (folder / "found.json").write_text(json.dumps(diagnosis), encoding="utf-8")
    lines = [",".join(table.dtype.names)]
    lines += [",".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in table]
    (folder / "found.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "found.json", folder / "found.csv"
