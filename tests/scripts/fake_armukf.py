#!/usr/bin/python3
"""Stands for armukf where montecarlo.py is tested: a record is its seed, and by that the estimate goes
well or is lost."""

import json
import os
import signal
import sys
from pathlib import Path

VALUES = {"a_m": 0.266479, "a_g": 0.647533, "k_g1": 20.0774, "k_g3": 24.178, "d_g": 0.030513, "k_a": 11.7552,
          "d_a": 0.00283465}


def option(name):
    return sys.argv[sys.argv.index(name) + 1]


def result(seed):
    parameters = {p: {"value": v * 1.01, "sd": v * 0.01} for p, v in VALUES.items()}
    told = {"parameters": parameters, "resets": 0, "simulation": {"fit_percent": 99.0},
            "innovation": {"mean_nis": 1.0}}
    if seed == 1:  # misses k_a
        parameters["k_a"]["value"] = 1.02 * VALUES["k_a"]
    if seed == 3:
        parameters["k_a"]["value"] = None
    if seed == 4:
        parameters["d_a"]["sd"] = None
    if seed == 5:
        told["resets"] = 1
    if seed == 6:
        told["simulation"]["fit_percent"] = None
    if seed == 7:
        told["simulation"]["fit_percent"] = 20.0
    if seed == 8:
        sys.exit("armukf: the numbers went wrong")
    if seed == 9:
        os.kill(os.getpid(), signal.SIGKILL)
    return told


if sys.argv[1] == "simulate":
    Path(option("-o")).write_text(option("--seed"))
elif option("--filter") == "none":
    print("unknown filter 'none'", file=sys.stderr)
    sys.exit(2)
else:
    print(json.dumps(result(int(Path(sys.argv[2]).read_text()))))
