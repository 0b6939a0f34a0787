"""The recursive estimate of samples that come as they come."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

from . import _core
from .model import ModelSource, filtered
from .recursive import Recursive
from .results import Estimate, Status


class Fate(IntEnum):
    """What becomes of a sample that comes."""

    TAKEN = 0
    LATE = 1  # those after it have been given out already
    REPEATED = 2  # of the time of another one
    ASTRAY = 3  # its time is far from all others'; taken if the next ones go on from there


@dataclass(frozen=True)
class FateCounts:
    """How many samples came to nothing, and how often the clock began anew."""

    late: int
    repeated: int
    astray: int
    new_clocks: int


class Track(Recursive[_core.Track]):
    """The estimate of one arm whose samples come early, late, twice, by a clock that was set, or again from where
    a checkpoint was made.

        track = armukf.Track(armukf.Model("arm.toml"), reorder_s=0.01)
        for t, u, y in source:
            track.put(t, u, y)
            for belief in track.ready():
                ...

    A Session refuses a time that is not later than the last one; a track sorts it in or says what became of it.
    model, filter: as of Session; reorder_s: s by which a sample may come later than those after it, which is how
    long each waits. A track works for one thread at a time.
    """

    def __init__(self, model: ModelSource = None, filter: str | None = None, *, reorder_s: float = 0.0) -> None:
        if not 0 <= reorder_s < math.inf:
            raise _core.InputError(f"reorder_s: must be at least 0 and finite, not {reorder_s}")
        start = filtered(model, filter)
        super().__init__(_core.Track(start._core, reorder_s), start)

    def put(self, t: float, u: float, y: float = math.nan) -> Fate:
        """Hands over a sample: t (s), u (N.m), y (rad/s; NaN: missing). InputError where t or u is no finite
        number or y is infinite. A sample that a loaded belief covers already counts as taken."""
        return Fate(self._core.put(t, u, y))

    def ready(self) -> Iterator[Estimate]:
        """What is believed after each sample that waits for no other, in the order of their times."""
        while (found := self._core.next()) is not None:
            t, u, y, y_pred, innovation, innovation_sd, nis, status, values, sd = found
            yield Estimate(t, u, y, y_pred, innovation, innovation_sd, nis, Status(status), self._names, values, sd)

    def end(self) -> None:
        """No more samples will be put: none waits any longer."""
        self._core.end()

    def expect_new_clock(self) -> None:
        """The samples' clock was set while nobody listened: none of them is old, whatever its time."""
        self._core.expect_new_clock()

    @property
    def counts(self) -> FateCounts:
        return FateCounts(*self._core.counts())

    def save(self) -> bytes:
        """Belief and counts, a checkpoint. It covers the samples up to the last estimate; those that wait do not
        count."""
        return self._core.save()

    def load(self, checkpoint: bytes) -> None:
        """Goes on from there, and passes over samples that it covers, so that the same stream may be put again.
        InputError where it is damaged or of another model; nothing changes then."""
        self._core.load(checkpoint)
