"""What jobs find. Where the program prints JSON, `json` holds the same, and the fields are its keys."""

from __future__ import annotations

import functools
import types
import typing
from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._html import table
from .model import Model

if TYPE_CHECKING:
    import pandas  # type: ignore[import]

Floats = NDArray[np.float64]
Result = TypeVar("Result")


class Status(IntEnum):
    """What became of a sample's measurement."""

    OK = 0  # used
    MISSING = 1  # there was none
    REJECTED = 2  # more than five deviations off; not used
    GAP = 3  # after a long interval; the states began anew
    RESET = 4  # too many rejected, or the numbers went wrong; the states began anew


@functools.cache
def _types_of(cls: Any) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def taken(kind: Any, value: Any) -> Any:
    """A value of JSON as a type of the classes below; null is NaN where a number is wanted."""
    if kind is float:
        return float("nan") if value is None else float(value)
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin in (Union, types.UnionType):
        return None if value is None else taken(inner[0], value)
    if origin is list:
        return [taken(inner[0], v) for v in value]
    if origin is dict:
        return {k: taken(inner[1], v) for k, v in value.items()}
    if is_dataclass(kind):
        return read(typing.cast(Any, kind), value)
    return value


def read(kind: Callable[..., Result], content: dict[str, Any], /, **more: Any) -> Result:
    """A result of that class from its JSON; `more` are the fields that JSON does not hold."""
    cls: Any = kind
    hints = _types_of(cls)
    held = {f.name: taken(hints[f.name], content[f.name])
            for f in fields(cls) if f.name in content and f.name not in more}
    return kind(**held, **more)


def _frame(columns: dict[str, Any]) -> pandas.DataFrame:
    try:
        import pandas
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError("to_pandas() needs pandas, Debian's python3-pandas") from error
    return pandas.DataFrame(columns)


def _status_column(status: NDArray[np.uint8]) -> Any:
    import pandas
    return pandas.Categorical.from_codes(status, _core.status_names())


def _position(names: tuple[str, ...], name: str) -> int:
    if name not in names:
        raise KeyError(f"no '{name}'; there are: {', '.join(names)}")
    return names.index(name)


def _with_deviations(names: tuple[str, ...], values: Floats, sd: Floats) -> dict[str, Floats]:
    return {**dict(zip(names, values.T)), **{f"{name}_sd": column for name, column in zip(names, sd.T)}}


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter as it was found, or is known."""

    value: float
    unit: str
    known: bool
    sd: float  # 0 for a known one
    sd_model: float | None = None  # that takes model and noise at their word
    sd_hac: float | None = None  # of a fit, for stationary residuals of any colour
    sd_blocks: float | None = None  # of a fit, by leaving an eighth of the records out in turn
    on_bound: bool = False

    def __str__(self) -> str:
        return f"{self.value:.6g} ± {self.sd:.2g} {self.unit}"


def parameter_table(parameters: dict[str, ParameterEstimate], caption: str) -> str:
    """HTML of those that are unknown."""
    rows = [(name, p.value, p.sd, p.unit) for name, p in parameters.items() if not p.known]
    return table(("parameter", "value", "sd", "unit"), rows, caption)


def _parameter_frame(parameters: dict[str, ParameterEstimate]) -> pandas.DataFrame:
    names = [f.name for f in fields(ParameterEstimate)]
    frame = _frame({name: [getattr(p, name) for p in parameters.values()] for name in names})
    frame.index = list(parameters)
    return frame


@dataclass(frozen=True)
class Estimate:
    """What is believed after one sample."""

    t: float  # s
    u: float  # N.m
    y: float  # rad/s; NaN where it is missing
    y_pred: float  # rad/s, before y was seen
    innovation: float  # rad/s, y - y_pred
    innovation_sd: float  # rad/s
    nis: float  # innovation^2 / innovation_sd^2
    status: Status
    names: tuple[str, ...] = field(repr=False)  # states, then unknown parameters
    values: Floats = field(repr=False)  # shape (len(names),), in units of the model
    sd: Floats = field(repr=False)  # the same shape

    def __getitem__(self, name: str) -> float:
        return float(self.values[_position(self.names, name)])

    def _repr_html_(self) -> str:
        return table(("", "value", "sd"), zip(self.names, self.values.tolist(), self.sd.tolist()),
                     f"After t = {self.t:g} s, {self.status.name.lower()}")


@dataclass(frozen=True)
class Estimates:
    """What is believed after each of n samples: the rows that the program writes, as columns.

    t, u and y are views of the array that was given.
    """

    t: Floats  # s, shape (n,), as all up to status
    u: Floats  # N.m
    y: Floats  # rad/s
    y_pred: Floats  # rad/s, before y was seen
    innovation: Floats  # rad/s, y - y_pred
    innovation_sd: Floats  # rad/s
    nis: Floats  # innovation^2 / innovation_sd^2
    status: NDArray[np.uint8]  # of Status
    names: tuple[str, ...]  # states, then unknown parameters
    units: tuple[str, ...]
    values: Floats  # shape (n, len(names)), in these units
    sd: Floats  # the same shape

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: str) -> Floats:
        """A state or parameter, shape (n,)."""
        return typing.cast(Floats, self.values[:, _position(self.names, name)])

    def sd_of(self, name: str) -> Floats:
        return typing.cast(Floats, self.sd[:, _position(self.names, name)])

    def to_pandas(self) -> pandas.DataFrame:
        """A row per sample, with the program's columns."""
        return _frame({"t": self.t, "y": self.y, "y_pred": self.y_pred, "innovation": self.innovation,
                       "innovation_sd": self.innovation_sd, "nis": self.nis,
                       "status": _status_column(self.status),
                       **_with_deviations(self.names, self.values, self.sd)})

    def __repr__(self) -> str:
        return f"<armukf.Estimates: {len(self)} samples of {', '.join(self.names)}>"

    def _repr_html_(self) -> str:
        if not len(self):
            return table((), (), "no samples")
        rows = zip(self.names, self.values[-1].tolist(), self.sd[-1].tolist(), self.units)
        return table(("", "value", "sd", "unit"), rows, f"{len(self)} samples, after the last one")


@dataclass(frozen=True)
class SimulationFit:
    """How well a model simulates a record."""

    fit_percent: float
    mse: float  # (rad/s)^2


@dataclass(frozen=True)
class Innovation:
    """What one-step errors say of a filter."""

    fit_percent: float
    rmse: float  # rad/s
    mean_nis: float
    ljung_box_p: float
    log_likelihood: float
    # A test: what is left is not noise, not white, or goes with torques. None where it was not made, as of `smooth`.
    model_lacks: bool | None = None
    torque_tests: dict[str, float] = field(default_factory=dict)  # by torque, the chance that noise does as much
    not_noise_percent: float | None = None


@dataclass(frozen=True)
class _Found:
    json: dict[str, Any] = field(repr=False, compare=False)


@dataclass(frozen=True)
class EstimateSummary(_Found):
    """What a recursive estimate ends with; `model` goes on from it."""

    model: Model = field(repr=False)
    samples: int
    missing: int
    rejected: int
    gaps: int
    resets: int
    filter: str
    innovation: Innovation
    simulation: SimulationFit  # by the final parameters, initial states fitted on the first tenth
    parameters: dict[str, ParameterEstimate]
    seconds: float

    @property
    def covariance(self) -> Floats:
        """Of the unknown parameters in their order, units of the parameters, to go with sd."""
        return np.array(self.json["covariance"]["matrix"])

    def to_pandas(self) -> pandas.DataFrame:
        """A row per parameter."""
        return _parameter_frame(self.parameters)

    def _repr_html_(self) -> str:
        return parameter_table(
            self.parameters, f"{self.filter}, {self.samples} samples, simulation fit "
            f"{self.simulation.fit_percent:.2f} %, mean NIS {self.innovation.mean_nis:.3f}")


@dataclass(frozen=True)
class InitialState:
    value: float
    sd: float  # 0 where it was not free


@dataclass(frozen=True)
class Experiment:
    """A record, or the piece of one between its gaps, and how a model does on it."""

    file: str
    from_s: float  # s, time of its first sample
    samples: int
    fit_percent: float
    mse: float  # (rad/s)^2
    initial_state: dict[str, InitialState]


@dataclass(frozen=True)
class Fit(_Found):
    """A batch estimate."""

    model: Model = field(repr=False)  # with the values found
    parameters: dict[str, ParameterEstimate]
    experiments: list[Experiment]
    fit_percent: float
    mse: float  # (rad/s)^2
    fpe: float
    aic: float
    bic: float
    iterations: int
    evaluations: int
    converged: bool
    termination: str  # why the search ended
    poorly_determined: list[str]  # parameters
    seconds: float

    def to_pandas(self) -> pandas.DataFrame:
        """A row per parameter."""
        return _parameter_frame(self.parameters)

    def _repr_html_(self) -> str:
        return parameter_table(
            self.parameters, f"{self.termination}, fit {self.fit_percent:.2f} %, MSE {self.mse:.5g} (rad/s)²")


@dataclass(frozen=True)
class Evaluation(_Found):
    """A model against one record, or a piece of it between gaps."""

    experiment: Experiment
    horizon: int | None  # samples ahead; None: simulated
    samples: Floats  # shape (n, 3): t, u, y
    y_hat: Floats  # rad/s, shape (n,), simulated or predicted
    ljung_box_p: float

    @property
    def fit_percent(self) -> float:
        return self.experiment.fit_percent

    @property
    def mse(self) -> float:
        """(rad/s)^2"""
        return self.experiment.mse

    @property
    def residual(self) -> Floats:
        """rad/s, y - y_hat, shape (n,)"""
        return typing.cast(Floats, self.samples[:, 2] - self.y_hat)

    def to_pandas(self) -> pandas.DataFrame:
        t, u, y = self.samples.T
        return _frame({"t": t, "u": u, "y": y, "y_hat": self.y_hat, "residual": self.residual})

    def _repr_html_(self) -> str:
        how = "simulated" if self.horizon is None else f"{self.horizon} samples ahead"
        return table(("record", "samples", "fit, %", "MSE, (rad/s)²", "Ljung-Box p"),
                     [(self.experiment.file, len(self.samples), self.fit_percent, self.mse,
                       self.ljung_box_p)], how)


@dataclass(frozen=True)
class Smoothed(_Found):
    """States and parameters of each of n samples given the whole record."""

    t: Floats  # s, shape (n,), a view of the record
    y: Floats  # rad/s, the same
    status: NDArray[np.uint8]  # of Status, of the filter's pass
    names: tuple[str, ...]  # states, then unknown parameters
    units: tuple[str, ...]
    values: Floats  # shape (n, len(names)), in these units
    sd: Floats  # the same shape
    filter: str
    innovation: Innovation
    parameters: dict[str, ParameterEstimate]
    seconds: float

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: str) -> Floats:
        """A state or parameter, shape (n,)."""
        return typing.cast(Floats, self.values[:, _position(self.names, name)])

    def to_pandas(self) -> pandas.DataFrame:
        """A row per sample, with the program's columns."""
        return _frame({"t": self.t, "y": self.y, "status": _status_column(self.status),
                       **_with_deviations(self.names, self.values, self.sd)})

    def _repr_html_(self) -> str:
        return parameter_table(self.parameters, f"{self.filter} and back over {len(self)} samples")


@dataclass(frozen=True)
class ComparedParameter:
    """A parameter by both estimates; the difference is recursive minus batch."""

    recursive: float
    recursive_sd: float
    batch: float
    batch_sd: float
    difference_percent: float  # of batch
    difference_sd: float  # in deviations of both


@dataclass(frozen=True)
class Comparison(_Found):
    """The recursive beside the batch estimate of a record."""

    recursive: EstimateSummary
    batch: Fit
    batch_simulation: SimulationFit  # found as recursive.simulation is
    parameters: dict[str, ComparedParameter]

    def to_pandas(self) -> pandas.DataFrame:
        """A row per unknown parameter."""
        names = [f.name for f in fields(ComparedParameter)]
        frame = _frame({name: [getattr(p, name) for p in self.parameters.values()] for name in names})
        frame.index = list(self.parameters)
        return frame

    def _repr_html_(self) -> str:
        heads = ("parameter", *(f.name.replace("_", " ") for f in fields(ComparedParameter)))
        rows = [(name, *vars(p).values()) for name, p in self.parameters.items()]
        return table(heads, rows, "Recursive beside batch")


@dataclass(frozen=True)
class Measures:
    """A model against a record, by simulation and one sample ahead."""

    fit_percent: float  # of the simulation
    mse: float  # (rad/s)^2, of the simulation
    one_step_rmse: float  # rad/s
    log_likelihood: float
    ljung_box_p: float


@dataclass(frozen=True)
class BeforeAfter:
    estimation: Measures
    validation: Measures  # on the blocks left out where there is no validation record


@dataclass(frozen=True)
class Effect:
    """An effect that was found."""

    name: str
    parameters: dict[str, ParameterEstimate]
    p_value: float
    mse_reduction_percent: float
    confused_with: list[str]  # that explain nearly as much
    site: str | None = None


@dataclass(frozen=True)
class Candidate:
    """An effect that was tried."""

    name: str
    round: int
    help_percent: float
    statistic: float
    p_value: float
    accepted: bool
    refused_because: str = ""
    site: str | None = None


@dataclass(frozen=True)
class Consistency:
    """What parts of the data say of a parameter, and the chance that they differ as much by chance."""

    parameter: str
    between: str
    values: list[float]
    sd: list[float]
    p_value: float


@dataclass(frozen=True)
class Diagnosis(_Found):
    """What the model lacks; `model` is the completed one."""

    model: Model = field(repr=False)
    verdict: str
    before: BeforeAfter
    after: BeforeAfter
    effects: list[Effect]
    candidates: list[Candidate]
    consistency: list[Consistency]
    unexplained: list[str]
    seconds: float
    samples: Floats = field(repr=False)  # shape (n, 3): those that judge
    residual_before: Floats = field(repr=False)  # rad/s, shape (n,): y less the simulation of them
    residual_after: Floats = field(repr=False)

    def to_pandas(self) -> pandas.DataFrame:
        """A row per candidate."""
        names = [f.name for f in fields(Candidate)]
        return _frame({name: [getattr(c, name) for c in self.candidates] for name in names})

    def _repr_html_(self) -> str:
        rows = [(e.name, e.p_value, e.mse_reduction_percent, ", ".join(e.confused_with)) for e in self.effects]
        before, after = self.before.validation, self.after.validation
        return table(("effect", "p", "MSE lower by, %", "or"), rows,
                     f"{self.verdict}: fit {before.fit_percent:.2f} → {after.fit_percent:.2f} %")


@dataclass(frozen=True)
class SimulatedExperiment:
    """A record, and what nobody measures."""

    samples: Floats  # shape (n, 3): t (s), u (N.m, as commanded), y (rad/s, as measured)
    states: Floats = field(repr=False)  # shape (n, len(names))
    names: tuple[str, ...]
    model: Model = field(repr=False)

    def to_pandas(self) -> pandas.DataFrame:
        t, u, y = self.samples.T
        return _frame({"t": t, "u": u, "y": y, **dict(zip(self.names, self.states.T))})

    def _repr_html_(self) -> str:
        return table(("", "least", "greatest"),
                     [(name, float(column.min()), float(column.max()))
                      for name, column in zip(("t", "u", "y"), self.samples.T)],
                     f"{len(self.samples)} samples")
