#!/usr/bin/python3
"""Turns the System Identification Toolbox's robotarmdata.mat into records for armukf, for users who
own it.

    import_robotarm.py robotarmdata.mat [-o FOLDER]

writes robotarm_estimation.csv and robotarm_validation1.csv to robotarm_validation3.csv: time (s),
torque u (N·m) and motor speed y (rad/s), sampled every 0.5 ms.
"""

import argparse
import os
import sys
from pathlib import Path

import numpy as np
from scipy import io

SAMPLE_TIME_S = 0.5e-3
RECORDS = {"robotarm_estimation": "e", "robotarm_validation1": "v1", "robotarm_validation2": "v2",
           "robotarm_validation3": "v3"}


class InputError(Exception):
    """What is wrong with the user's input, in one line."""


def load(path):
    try:
        with open(path, "rb") as file:
            return io.loadmat(file)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except NotImplementedError:
        raise InputError(f"{path}: is of version 7.3 (HDF5); in MATLAB, save it with -v7") from None
    except Exception as error:  # scipy raises many kinds for a file that is no .mat
        raise InputError(f"{path}: is no .mat file: {str(error).splitlines()[0]}") from None


def signal_of(content, path, name):
    if name not in content:
        raise InputError(f"{path}: has no variable {name}")
    values = np.asarray(content[name])
    if not np.issubdtype(values.dtype, np.number) or values.size != max(values.shape, default=0):
        raise InputError(f"{path}: {name} is not one column of numbers")
    return values.astype(float).ravel()


def write(path, u, y):
    """The whole file or none."""
    part = path.with_suffix(".part")
    with open(part, "w", encoding="utf-8") as file:
        file.write("t,u,y\n")
        for k, (torque, speed) in enumerate(zip(u, y)):
            file.write(f"{k * SAMPLE_TIME_S:.4f},{float(torque)!r},{float(speed)!r}\n")
    os.replace(part, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("mat", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("."), metavar="FOLDER")
    options = parser.parse_args()
    content = load(options.mat)
    records = {}
    for name, suffix in RECORDS.items():
        u, y = (signal_of(content, options.mat, kind + suffix) for kind in "uy")
        if len(u) != len(y):
            raise InputError(f"{options.mat}: u{suffix} has {len(u)} samples, y{suffix} {len(y)}")
        records[name] = u, y
    try:
        options.output.mkdir(parents=True, exist_ok=True)
        for name, (u, y) in records.items():
            write(options.output / f"{name}.csv", u, y)
    except OSError as error:
        raise InputError(f"{options.output}: {error.strerror}") from None


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
