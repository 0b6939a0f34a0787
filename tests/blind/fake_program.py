#!/usr/bin/python3
"""Stands for blind_plant and for armukf where blind_score.py is tested: a record is the list of its
effects, and the error grows by the square of the size of each one that the model lacks."""

import json
import sys
from pathlib import Path

NULL_ERROR = 0.04  # (rad/s)^2
KNOWN = {"torque_bias", "flexible_mode", "drive_lag", "sensor_lag", "gravity"}


def values_of(option):
    a = sys.argv
    return [a[i + 1] for i in range(len(a) - 1) if a[i] == option]


def known(name):
    return name.split(".")[0]


def error(record, effects):
    return NULL_ERROR + sum(s * s for n, s in record["effects"].items() if known(n) not in effects)


def diagnose(record):
    effects = []
    for name, size in record["effects"].items():
        if name == "gravity":
            sys.exit("line one\nthe numbers went wrong")
        if known(name) in KNOWN and size > 0.2:
            told = "drive_lag" if name == "sensor_lag" else known(name)
            effects.append({"name": told, "confused_with": ["sensor_lag"] * (told == "drive_lag")})
    if record["seed"] == "7" and not record["effects"]:
        effects.append({"name": "drive_lag", "confused_with": []})
    before = error(record, [])
    after = before - 0.75 * (before - NULL_ERROR) if effects else before
    verdict = "effect found" if effects else "model sufficient"
    return {"before": {"validation": {"mse": before}}, "after": {"validation": {"mse": after}},
            "effects": effects, "verdict": verdict}


def main():
    if values_of("--estimation"):
        effects = dict((n, float(s)) for n, s in (e.split("=") for e in values_of("--effect")))
        text = json.dumps({"effects": effects, "seed": values_of("--seed")[0]})
        for path in values_of("--estimation") + values_of("--validation"):
            Path(path).write_text(text)
        return
    command, record = sys.argv[1], json.loads(Path(sys.argv[2]).read_text())
    if command == "fit":
        if not set(values_of("--effect")) <= KNOWN:
            sys.exit("unknown effect")
        Path(values_of("--save")[0]).write_text(json.dumps(values_of("--effect")))
        print("{}")
    elif command == "evaluate":
        effects = json.loads(Path(values_of("--model")[0]).read_text())
        print(json.dumps({"experiments": [{"mse": error(record, effects)}]}))
    else:
        print(json.dumps(diagnose(record)))


main()
