"""How large the effects of the blind cases are, in tests/blind/sizes.json.

An effect is sized by what it does to somebody who does not know of it: the validation error of the
plain model, fitted to the record with the effect, over that on the record of the same seed without
it. Both arms are under the same controller and noise; the controller answers the effect, and so the
torques differ, as they would. A size in the open loop would be cheaper and mean less: what feedback
and refitting hide is gone. The size is searched for, once, with `armukf fit` and `evaluate` on the
plain model, which diagnose has no part in, and kept, so that another version of the program is tried
on the same records. The growth that a version finds stands in each row of its score. A size at which
the loop of any of the case's records hunts is too large.

Where the largest size that the plant allows, or that its loops bear, grows less than is wanted, the
draw is taken as a place between the least and that.
"""

import json
import math
import tempfile
import threading
from datetime import date

from blind_cases import growth_at, part_at
from blind_programs import (ROOT, Failure, described_tree, in_parallel, largest_sizes, make_records,
                            plain_errors)

SIZES = ROOT / "tests/blind/sizes.json"
TOLERANCE = 0.2  # of the growth beyond 1; a draw need not be met closely
TRIALS = 14


def size_for(wanted, growth, largest, start):
    """The size whose growth(size) is `wanted`, and that growth; growth beyond 1 is taken for a power
    of the size near the answer. What comes closest if none grows as far."""
    low, high = None, None  # (log size, log of growth beyond 1), below and above
    tried = {}
    size = min(start, largest)
    for _ in range(TRIALS):
        size = float(f"{size:.4g}")
        if size in tried:
            break
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
        size = min(math.exp(next_size(low, high)), largest)
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


def calibrated(programs, case, index, limits):
    """Size and growth of one effect of the case, alone in its arm."""
    name, wanted = case.wanted[index]
    with tempfile.TemporaryDirectory() as folder:
        null = plain_errors(programs, *make_records(programs, (), case.seed, folder))["validation"]

        def growth(size):
            try:
                made = make_records(programs, ((name, size),), case.seed, folder)
                return plain_errors(programs, *made)["validation"] / null
            except Failure:
                return math.inf

        size, reached = size_for(wanted, growth, limits[1], limits[0])
        if reached < 1 + (1 - 1.5 * TOLERANCE) * (wanted - 1):
            wanted = reachable(wanted, reached, len(case.wanted))
            size, reached = size_for(wanted, growth, size, size)
    return {"wanted": round(wanted, 3), "size": size, "growth": float(f"{reached:.4g}")}


def reachable(wanted, reached, share):
    """As far between the least and what is reached as `wanted` is between the least and the most."""
    least, most = math.log(growth_at(0, share)), math.log(max(reached, growth_at(0, share)))
    return math.exp(least + part_at(wanted, share) * (most - least))


def key(case, index):
    return f"{case.seed} {case.wanted[index][0]}"


def known_sizes():
    if not SIZES.exists():
        return {"made": [], "sizes": {}}
    return json.loads(SIZES.read_text())


def save(known):
    lines = [f'  "{k}": {json.dumps(v)}' for k, v in sorted(known["sizes"].items())]
    made = ",\n".join("  " + json.dumps(m) for m in known["made"])
    SIZES.write_text('{"made": [\n' + made + '\n],\n"sizes": {\n' + ",\n".join(lines) + "\n}}\n")


def calibrate(programs, cases, jobs):
    """Adds the sizes that are not yet known, and what found them."""
    known = known_sizes()
    tasks = [(case, i) for case in cases for i in range(len(case.wanted))
             if key(case, i) not in known["sizes"]]
    limits = largest_sizes(programs)
    known["made"].append({**programs.stamp(), "tree": described_tree(), "date": str(date.today()),
                          "sizes": len(tasks)})
    lock = threading.Lock()

    def kept(task):
        case, index = task
        found = calibrated(programs, case, index, limits[case.wanted[index][0]])
        with lock:
            known["sizes"][key(case, index)] = found
            save(known)

    in_parallel(kept, tasks, jobs)


def sized(case, sizes):
    """The (name, size) of the case's effects."""
    keys = [key(case, i) for i in range(len(case.wanted))]
    if not set(keys) <= set(sizes):
        raise SystemExit(f"no size of {', '.join(keys)}: run --calibrate")
    return tuple((name, sizes[k]["size"]) for k, name in zip(keys, case.names))
