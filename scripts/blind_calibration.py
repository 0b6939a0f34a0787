"""Sizes of the blind plant's effects at which the plain model's validation error grows as wanted."""

import json
import math

from blind_cases import (CATALOGUE, FOREIGN, SIZES, SURROUNDINGS, Failure, in_parallel, plain_error)

GROWTH = {"large": 2.5, "small": 1.35}  # MSE over that of the null record of the same seed
TOLERANCE = 0.08                        # of the growth beyond 1
TRIALS = 16
SMALLEST = 1e-4
LARGEST = 30.0
# Beyond these the effect is another one: the oscillator takes its whole site, the lag the whole loop.
LARGEST_OF = {"flexible_mode.motor": 3.5, "flexible_mode.gear": 3.5, "flexible_mode.arm": 3.5,
              "two_modes": 3.5, "torque_gain": 20.0, "thermal_friction": 15.0, "backlash": 20.0}


def size_for(wanted, growth, largest, start=1.0):
    """The size whose growth(size) is `wanted`, and that growth; growth beyond 1 is taken for a power
    of the size near the answer. The largest size if it does not grow as far."""
    low, high = None, None  # (log size, log of growth beyond 1), below and above
    tried = {}
    size = min(start, largest)
    for _ in range(TRIALS):
        size = float(f"{size:.4g}")
        tried[size] = growth(size)
        excess = tried[size] - 1.0
        if abs(excess / (wanted - 1.0) - 1.0) < TOLERANCE:
            break
        point = math.log(size), math.log(max(excess, 1e-3) / (wanted - 1.0))
        if point[1] < 0.0:
            low = point
            if size >= largest:
                break
        else:
            high = point
        size = math.exp(next_size(low, high))
        size = min(max(size, SMALLEST), largest)
    best = min(tried, key=lambda s: abs(math.log(max(tried[s] - 1.0, 1e-3) / (wanted - 1.0))))
    return best, tried[best]


def next_size(low, high):
    if low and high:
        if not math.isfinite(high[1]):
            return 0.5 * (low[0] + high[0])
        part = low[1] / (low[1] - high[1])
        return low[0] + min(max(part, 0.1), 0.9) * (high[0] - low[0])
    known = low or high
    # Growth is mostly quadratic; an unstable loop (infinite) says only that the size is too large.
    step = -known[1] / 2.0 if math.isfinite(known[1]) else -1.0
    return known[0] + min(max(step, -3.0), 3.0)


def calibrated(programs, name, seed, known=None):
    """Size and growth of each kind for that seed; the search begins at the known sizes."""
    null = plain_error(programs, (), seed)

    def growth(size):
        try:
            return plain_error(programs, ((name, size),), seed) / null
        except Failure:
            return math.inf

    largest = LARGEST_OF.get(name, LARGEST)
    sizes = {}
    start = 1.0
    for group, wanted in GROWTH.items():
        if known:
            start = known[group][seed - 1]["size"]
        start, reached = size_for(wanted, growth, largest, start)
        sizes[group] = {"size": start, "growth": float(f"{reached:.3g}")}
    return sizes


def calibrate(programs, names, jobs):
    """Writes the sizes, one of each kind per surroundings; those of other effects stay."""
    wanted = [n for n in CATALOGUE + FOREIGN if n in names]
    tasks = [(name, seed) for name in wanted for seed in range(1, len(SURROUNDINGS) + 1)]
    sizes = json.loads(SIZES.read_text()) if SIZES.exists() else {}
    found = in_parallel(lambda task: calibrated(programs, *task, sizes.get(task[0])), tasks, jobs)
    for name in wanted:
        of_name = [f for (n, _), f in zip(tasks, found) if n == name]
        sizes[name] = {group: [f[group] for f in of_name] for group in GROWTH}
    lines = []
    for name in CATALOGUE + FOREIGN:
        if name in sizes:
            kinds = [f'    "{g}": {json.dumps(sizes[name][g])}' for g in GROWTH]
            lines.append(f'  "{name}": {{\n' + ",\n".join(kinds) + "\n  }")
    SIZES.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    return sizes
