"""What has become of a quantity from record to record: nothing, a step, or a drift."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

TRUST = 8.0  # degrees of freedom: how far the deviations are believed where records scatter otherwise
STRAY = 5.0  # deviations, from both neighbours' side


@dataclass(frozen=True)
class Change:
    how: str      # step or drift
    begins: int   # the first point that is another; of a drift the first of all
    start: float
    end: float
    sd: float     # of end - start
    p: float      # of it being chance, given all that was looked at

    @property
    def size(self):
        """In deviations."""
        return abs(self.end - self.start) / self.sd


def strays(values, sds):
    """Which points stand alone, off the median of themselves and their neighbours, as a fit does that has ended
    in a side valley. Steps and drifts have none. The first and the last cannot be told."""
    values, sds = np.asarray(values, float), np.asarray(sds, float)
    found = np.zeros(len(values), bool)
    for i in range(1, len(values) - 1):
        middle = i - 1 + int(np.argsort(values[i - 1:i + 2])[1])
        found[i] = abs(values[i] - values[middle]) > STRAY * np.hypot(sds[i], sds[middle])
    return found


def line(column, values, sds):
    """(offset, slope, sd of the slope) of values = offset + slope column, by weighted least squares. The
    variances are scaled by the scatter about it, as if TRUST more points had scattered as told."""
    weights = sds**-2
    centre, mean = (np.sum(weights * x) / np.sum(weights) for x in (column, values))
    information = np.sum(weights * (column - centre) ** 2)
    slope = np.sum(weights * (column - centre) * values) / information
    left = np.sum(weights * (values - mean - slope * (column - centre)) ** 2)
    scale = (TRUST + left) / (TRUST + len(values) - 2)
    return mean - slope * centre, slope, float(np.sqrt(scale / information))


def change_of(times, values, sds, looks):
    """The likeliest change of a series in order of time, however unlikely; None of fewer than two points.
    `looks`: how many series were looked at."""
    times, values, sds = (np.asarray(x, float) for x in (times, values, sds))
    count = len(values)
    candidates = [("step", k, (np.arange(count) >= k).astype(float)) for k in range(1, count)]
    if count > 2 and times[-1] > times[0]:
        candidates.append(("drift", 0, (times - times[0]) / (times[-1] - times[0])))
    changes = []
    for how, begins, column in candidates:
        offset, slope, sd = line(column, values, sds)
        p = 2.0 * stdtr(TRUST + count - 2, -abs(slope) / sd) * len(candidates) * looks
        changes.append(Change(how, begins, float(offset), float(offset + slope), sd, min(1.0, float(p))))
    return max(changes, key=lambda c: c.size, default=None)


def rate_of(times, values, sds):
    """(slope, its sd) per unit of time; None of fewer than three points, or all at a time."""
    if len(values) < 3 or max(times) == min(times):
        return None
    return tuple(map(float, line(*(np.asarray(x, float) for x in (times, values, sds)))[1:]))
