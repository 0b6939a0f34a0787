#!/usr/bin/python3
"""Stands for armukf where fleet.py is tested: a record holds `k_a`, its deviation and what else it is to do. Every
call leaves its words in the file `calls` beside the record."""

import json
import os
import signal
import sys
from pathlib import Path

words = sys.argv[1:]
record = next(Path(word) for word in words[1:] if word.endswith(".csv"))
with (record.parent / "calls").open("a") as calls:
    calls.write(json.dumps(words) + "\n")
if not record.exists():
    sys.exit(f"{record}: no such file")
told = record.read_text().split()
if told[0] == "broken":
    print(f"{record}:17: u: '{told[1]}' is not a number", file=sys.stderr)
    sys.exit(2)
if told[0] == "dies":
    os.kill(os.getpid(), signal.SIGKILL)
parameters = {"k_a": {"value": float(told[0]), "sd": float(told[1]), "unit": "N.m/rad", "known": False},
              "J": {"value": 0.03, "sd": 0.0, "unit": "kg.m^2", "known": True}}
if words[0] == "fit":
    print(json.dumps({"parameters": parameters, "fit_percent": 99.0}))
if words[0] == "estimate":
    event = {"t": 5.2, "onset": 5.0, "what": "k_a", "from": 10.0, "to": 12.1, "sd": 0.3, "p": 0.97,
             "also_possible": ["a_g"], "settled": False}
    settled = {**event, "t": 6.6, "to": 12.0, "sd": 0.1, "settled": True}
    Path(words[words.index("--events") + 1]).write_text(
        "".join(json.dumps(e) + "\n" for e in (event, settled)) if "event" in told else "")
    print(json.dumps({"parameters": parameters, "simulation": {"fit_percent": 98.0}}))
if words[0] == "diagnose":
    effect = {"name": "backlash", "parameters": {"backlash_gap": {"value": 0.02, "sd": 0.001, "unit": "rad",
                                                                 "known": False}},
              "p_value": 1e-9, "mse_reduction_percent": 40.0, "confused_with": ["gear_hysteresis"]}
    print(json.dumps({"effects": [effect] if "effect" in told else [], "unexplained": [],
                      "after": {"estimation": {"fit_percent": 97.0}}}))
