"""Tables and JSON that armukf wrote, for the scripts that draw them."""

import json

import numpy as np


class InputError(Exception):
    """What is wrong with the user's input, in one line."""


def read_table(path, needed):
    try:
        with open(path, encoding="utf-8") as file:
            lines = [line for line in file if line.strip() and not line.startswith("#")]
        if not lines:
            raise InputError(f"{path}: file is empty")
        table = np.genfromtxt(lines, delimiter=",", names=True, dtype=None, encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error).splitlines()[0]
        raise InputError(f"{path}: {reason}") from None
    for column in needed:
        if table.dtype.names is None or column not in table.dtype.names:
            raise InputError(f"{path}: no column {column}")
    if table.ndim == 0 or len(table) < 2:
        raise InputError(f"{path}: holds fewer than two rows")
    for column in needed:
        if table[column].dtype.kind not in "fiu":
            raise InputError(f"{path}: {column}: {first_text(table[column])!r} is not a number")
    return table


def first_text(column):
    """The first value of a column of text that is no number."""
    for value in column:
        try:
            float(value)
        except ValueError:
            return str(value)
    return str(column[0])


def read_json(path, *keys):
    try:
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
        for key in keys:
            found = found[key]
        return found
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except (ValueError, KeyError, IndexError, TypeError):
        raise InputError(f"{path}: holds no {keys[-1]}; is it what armukf wrote?") from None
