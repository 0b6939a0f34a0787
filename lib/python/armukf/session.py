"""The recursive estimate, sample by sample or an array at a time."""

from __future__ import annotations

import math

from . import _core
from .model import ModelSource, filtered
from .recursive import Recursive
from .results import Estimate, Estimates, Floats, Status


class Session(Recursive[_core.Session]):
    """A recursive estimate of states and unknown parameters: samples in, what is believed out.

        session = armukf.Session(armukf.Model("arm.toml"))
        belief = session.step(t, u, y)        # beside the robot
        rows = session.run(samples)           # or a stretch of samples at once, shape (n, 3)

    Both go on from what was believed before, and give the same numbers. A session works for one thread at a
    time, and says so; run() lets other threads go on. model: one that is copied, the path of a model file, or
    None for the published arm; filter: ukf, ekf and so on, by default the model's.
    """

    def __init__(self, model: ModelSource = None, filter: str | None = None) -> None:
        start = filtered(model, filter)
        super().__init__(_core.Session(start._core), start)
        self._units = tuple(start.units)

    @property
    def units(self) -> tuple[str, ...]:
        return self._units

    def step(self, t: float, u: float, y: float = math.nan) -> Estimate:
        """Takes a sample: t (s, later than the last one), u (N.m), y (rad/s; NaN: missing).

        InputError where t or u is no finite number, y is infinite, or t is not later; the belief is then as
        it was.
        """
        y_pred, innovation, innovation_sd, nis, status, values, sd = self._core.step(t, u, y)
        return Estimate(t, u, y, y_pred, innovation, innovation_sd, nis, Status(status), self._names, values,
                        sd)

    def run(self, samples: Floats) -> Estimates:
        """Takes samples, float64 of shape (n, 3) in C order: t (s), u (N.m), y (rad/s; NaN: missing).

        They are read where they lie, and checked as those of step() before the first one is taken. Other
        threads go on meanwhile; Ctrl-C ends it within some tenths of a second, with what was believed then.
        """
        innovations, status, values, sd = self._core.run(samples)
        t, u, y = samples.T
        y_pred, innovation, innovation_sd, nis = innovations
        return Estimates(t, u, y, y_pred, innovation, innovation_sd, nis, status, self._names, self._units,
                         values, sd)

    def expect_new_clock(self) -> None:
        """The clock was set: the next time may be any, and how long ago the last sample was is not known."""
        self._core.expect_new_clock()

    @property
    def covariance(self) -> Floats:
        """Of the unknown parameters in their order, units of the parameters, to go with their sd."""
        return self._core.covariance()

    @property
    def decided(self) -> bool:
        """Whether the race of the starts is over."""
        return self._core.decided()

    def save(self) -> bytes:
        """The whole belief; a session of the same model and settings goes on from it bit by bit."""
        return self._core.save()

    def load(self, belief: bytes) -> None:
        """Takes such a belief. InputError where it is damaged or of another model; nothing changes then."""
        self._core.load(belief)
