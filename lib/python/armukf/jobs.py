"""Whole records at once. Each job does what the program's command of its name does, with its defaults.

Other threads go on meanwhile. Ctrl-C ends smooth and fit soon (by predictions in some seconds), compare when its
recursive half is done, and diagnose at its next stage; the other jobs finish first.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral
from typing import Any, Literal, Union, cast

from . import _core
from .model import Model, ModelSource, filtered
from .results import (Comparison, Diagnosis, EstimateSummary, Evaluation, Experiment, Fit, Floats,
                      SimulatedExperiment, Smoothed, read, taken)

Path = Union[str, "os.PathLike[str]"]
Record = Union[Floats, Path]
Records = Union[Record, Sequence[Record]]
_MOST_SAMPLES = 5_000_000  # with all states half a gigabyte
_MOST_SEED = 2**64 - 1
FreeInitial = Union[Literal["all", "none"], Sequence[str], None]


def read_record(path: Path, t: str = "t", u: str = "u", y: str = "y") -> Floats:
    """The samples of a CSV file, shape (n, 3); t, u, y: what their columns are called there."""
    return _core.read_record(os.fspath(path), t, u, y)


def _named(record: Record, name: str) -> tuple[str, Floats]:
    if isinstance(record, (str, os.PathLike)):
        return os.fspath(record), read_record(record)
    return name, record


def _all_named(records: Records, name: str) -> list[tuple[str, Floats]]:
    if isinstance(records, (list, tuple)):
        return [_named(record, f"{name}[{k}]") for k, record in enumerate(records)]
    return [_named(cast(Record, records), name)]


def _whole(least: int, most: int = 2**31 - 1, **values: int | None) -> None:
    for name, value in values.items():
        if value is None:
            continue
        if not isinstance(value, Integral) or not least <= value <= most:
            raise _core.InputError(f"{name}: must be a whole number from {least} to {most}, not '{value}'")


def _not_negative(**values: float) -> None:
    for name, value in values.items():
        if not 0 <= value < math.inf:
            raise _core.InputError(f"{name}: must be at least 0 and finite, not {value}")


def _position(model: Model, state: str) -> int:
    if state not in model.states:
        raise _core.InputError(f"unknown state '{state}'; known are: {', '.join(model.states)}")
    return model.states.index(state)


def _initial(model: Model, free: FreeInitial,
             given: Mapping[str, float] | None) -> tuple[list[int] | None, dict[int, float]]:
    values = {_position(model, state): float(value) for state, value in (given or {}).items()}
    if not all(map(math.isfinite, values.values())):
        raise _core.InputError(f"initial: must be finite, not {given}")
    if free is None:
        return None, values
    if isinstance(free, str):
        free = model.states if free == "all" else [] if free == "none" else [free]
    return [_position(model, state) for state in free], values


def simulate(model: ModelSource = None, experiment: str = "estimation", *, seed: int = 1,
             samples: int = 19838, sample_time_s: float = 5e-4, sensor_noise: float = 0.0,
             sensor_pole: float = 0.0, torque_disturbance: float = 0.0,
             torque_pole: float = 0.0) -> SimulatedExperiment:
    """One experiment of the arm under speed control; by default of the published estimate.

    experiment: estimation, validation1, validation2 or validation3. sensor_noise (rad/s) and
    torque_disturbance (N.m, held per sample) are deviations of noise, white unless their poles say
    otherwise: that of e' = pole e + white noise from sample to sample, 0 to 0.999.
    """
    _whole(1, _MOST_SAMPLES, samples=samples)
    _whole(0, _MOST_SEED, seed=seed)
    _not_negative(sensor_noise=sensor_noise, torque_disturbance=torque_disturbance)
    for name, pole in (("sensor_pole", sensor_pole), ("torque_pole", torque_pole)):
        if not 0 <= pole <= 0.999:
            raise _core.InputError(f"{name}: must be from 0 to 0.999, not {pole}")
    if not 0 < sample_time_s <= 0.002:
        raise _core.InputError(f"sample_time_s: must be above 0 and at most 0.002, not {sample_time_s}")
    chosen = Model.published_estimate() if model is None else Model(model)
    record, states = _core.simulate(chosen._core, experiment, seed, samples, sample_time_s, sensor_noise,
                                    sensor_pole, torque_disturbance, torque_pole)
    return SimulatedExperiment(record, states, tuple(chosen.states), chosen)


def estimate(record: Record, model: ModelSource = None, *, filter: str | None = None,
             passes: int = 1) -> EstimateSummary:
    """The recursive estimate of a record, each pass from the parameters that the last one ended with.

    Session.run() gives what was believed after each sample.
    """
    _whole(1, passes=passes)
    text, found = _core.estimate(_named(record, "record"), filtered(model, filter)._core, passes)
    return _summary(json.loads(text), Model._of(found))


def _summary(content: dict[str, Any], model: Model) -> EstimateSummary:
    return read(EstimateSummary, content, json=content, model=model)


def score(record: Record, model: ModelSource = None, *, filter: str | None = None) -> dict[str, Any]:
    """Likelihood and innovations of one pass, for tuning: what `armukf estimate --score` prints, for the
    whole record as its only part."""
    return dict(json.loads(_core.score(_named(record, "record"), filtered(model, filter)._core)))


def smooth(record: Record, model: ModelSource = None, *, filter: str | None = None, passes: int = 3,
           progress: Callable[[float], None] | None = None) -> Smoothed:
    """States and parameters of each sample given the whole record, by ukf, ekf or ckf.

    passes: of the filter, the last of which is smoothed. progress is told the share that is done.
    """
    _whole(1, passes=passes)
    named, chosen = _named(record, "record"), filtered(model, filter)
    text, status, values, sd = _core.smooth(named, chosen._core, passes, progress)
    content = json.loads(text)
    return read(Smoothed, content, json=content, t=named[1][:, 0], y=named[1][:, 2], status=status,
                names=(*chosen.states, *chosen.unknowns), units=tuple(chosen.units), values=values,
                sd=sd)


def fit(records: Records, model: ModelSource = None, *,
        criterion: Literal["simulation", "prediction"] = "simulation", starts: int = 1, seed: int = 1,
        threads: int = 0, robust: bool = False, iterations: int = 100, blocks: bool = True,
        free_initial: FreeInitial = None, initial: Mapping[str, float] | None = None) -> Fit:
    """The batch estimate of the model's unknown parameters from one record or a list of them.

    criterion: error of the plain simulation, or of the prediction one sample ahead. starts: searches, all but
    the first from drawn start values. threads: 0 is one per processor; no result depends on it. robust: by
    Huber's loss. blocks: leave an eighth of the records out in turn, for deviations that also hold where the model
    is incomplete. free_initial: states that are free at the first sample, by name, "all" or "none"; initial:
    values of others.
    """
    if criterion not in ("simulation", "prediction"):
        raise _core.InputError(f"criterion: must be simulation or prediction, not {criterion}")
    _whole(1, starts=starts, iterations=iterations)
    _whole(0, _MOST_SEED, seed=seed)
    _whole(0, threads=threads)
    chosen = Model(model)
    text, found = _core.fit(_all_named(records, "records"), chosen._core, criterion == "prediction", starts,
                            seed, threads, robust, iterations, blocks, *_initial(chosen, free_initial, initial))
    return _fit(json.loads(text), Model._of(found))


def _fit(content: dict[str, Any], model: Model) -> Fit:
    return read(Fit, content, json=content, model=model)


def evaluate(records: Records, model: ModelSource = None, *, horizon: int | None = None,
             initial_from: float | None = None, free_initial: FreeInitial = None,
             initial: Mapping[str, float] | None = None) -> list[Evaluation]:
    """The model as it is against records: an evaluation for each piece between their gaps.

    horizon: samples to predict ahead; None simulates. initial_from: find all initial states on this first part
    of a record (0 to 1). free_initial, initial: as in fit().
    """
    _whole(1, horizon=horizon)
    if initial_from is not None and not 0 < initial_from <= 1:
        raise _core.InputError(f"initial_from: must be above 0 and at most 1, not {initial_from}")
    chosen = Model(model)
    text, pieces = _core.evaluate(_all_named(records, "records"), chosen._core, horizon, initial_from,
                                  *_initial(chosen, free_initial, initial))
    return [Evaluation(content, read(Experiment, content), horizon, samples, y_hat,
                       taken(float, content["residual"]["ljung_box_p"]))
            for content, (samples, y_hat) in zip(json.loads(text)["experiments"], pieces)]


def compare(record: Record, model: ModelSource = None, *, filter: str | None = None, passes: int = 1,
            starts: int = 1, threads: int = 0, free_initial: FreeInitial = None,
            initial: Mapping[str, float] | None = None) -> Comparison:
    """The recursive beside the batch estimate of a record; free_initial="all" compares like with like."""
    _whole(1, passes=passes, starts=starts)
    _whole(0, threads=threads)
    chosen = filtered(model, filter)
    text, recursive, batch = _core.compare(_named(record, "record"), chosen._core, passes, starts, threads,
                                           *_initial(chosen, free_initial, initial))
    content = json.loads(text)
    return read(Comparison, content, json=content,
                recursive=_summary(content["recursive"], Model._of(recursive)),
                batch=_fit(content["batch"], Model._of(batch)))


def diagnose(record: Record, validate: Records = (), model: ModelSource = None, *,
             most_effects: int = 8, threads: int = 0,
             progress: Callable[[str, float], None] | None = None) -> Diagnosis:
    """What the model lacks: finds effects, adds them, and reports before and after.

    validate: other records of the same arm that judge; without them blocks of the record do that are left
    out in turn. Where noise is all that the completed model leaves, and one model explains all records, its
    values in the end are those that make all of them likeliest. progress is told the stage and the share that
    is done. Takes a minute or so.
    """
    _whole(1, most_effects=most_effects)
    _whole(0, threads=threads)
    text, completed, samples, before, after = _core.diagnose(
        _named(record, "record"), _all_named(validate, "validate"), Model(model)._core, most_effects, threads,
        progress)
    content = json.loads(text)
    return read(Diagnosis, content, json=content, model=Model._of(completed), samples=samples,
                residual_before=before, residual_after=after)


def start_from_slow_motion(record: Record, model: ModelSource = None) -> Model:
    """The model with friction and the total inertia J from a record of slow motion, without any guess."""
    return Model._of(_core.start_from_slow_motion(_named(record, "record"), Model(model)._core))


def start_from_frequency_response(record: Record, model: ModelSource = None) -> Model:
    """The model with masses and springs from the frequency response of a record, without any guess."""
    return Model._of(_core.start_from_frequency_response(_named(record, "record"), Model(model)._core))
