"""The arm: parameters, effects, and what a filter is told of noise and start."""

from __future__ import annotations

import json
import numbers
import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Union

from . import _core
from ._html import table


@dataclass(frozen=True)
class Parameter:
    """A constant of the model."""

    name: str
    unit: str
    value: float  # start value of an unknown, or the value of a known one
    lower: float
    upper: float
    scale: float  # a typical size
    known: bool
    spread: float  # prior sd of the start value, relative to it (or to scale)


def effect_names() -> list[str]:
    """The effects that a model may have."""
    return _core.effect_names()


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return repr(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_toml(k)} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    raise _core.InputError(f"a {type(value).__name__} is no value of a model file")


class Model:
    """The arm with the effects that it is taken to have, and all that an estimate is told beside its samples.

    Model() is the arm of the published study with its seven unknowns, Model("arm.toml") that of a model file,
    Model(other) a copy. What changes a model returns it, so that changes can be chained:

        armukf.Model().set(k_a=12.0).free("J").fix("k_g3").add_effect("backlash")

    A change that is refused leaves the model as it was. Sessions and jobs keep a copy of theirs.
    """

    __slots__ = ("_core",)

    def __init__(self, source: ModelSource = None) -> None:
        if source is None:
            self._core = _core.Model()
        elif isinstance(source, Model):
            self._core = _core.Model(source._core)
        else:
            self._core = _core.Model(os.fspath(source))

    @classmethod
    def _of(cls, core: _core.Model) -> Model:
        model = cls.__new__(cls)
        model._core = core
        return model

    @classmethod
    def from_text(cls, toml: str, name: str = "model") -> Model:
        """The model of a model file's text; `name` stands for the file in messages."""
        return cls._of(_core.Model.parsed(toml, name))

    @classmethod
    def published_estimate(cls) -> Model:
        """The arm with the published batch estimate of its unknowns."""
        return cls._of(_core.Model.published_estimate())

    def set(self, values: Mapping[str, Any] | None = None, /, **more: Any) -> Model:
        """Values of parameters by name, and settings by their dotted names in a model file.

        set(k_a=12.0), set({"noise.sensor": 0.05, "noise.model_error.gain": 0.0, "filter.kind": "ekf"})
        """
        lines = []
        for name, value in {**(values or {}), **more}.items():
            path = name.split(".") if "." in name else ["parameters", name, "value"]
            lines.append(".".join(map(_toml, path)) + f" = {_toml(value)}\n")
        return self.update("".join(lines), "set")

    def free(self, *names: str) -> Model:
        """Takes parameters for unknown."""
        return self._set_each(names, "free", "known", False)

    def fix(self, *names: str) -> Model:
        """Takes parameters for known."""
        return self._set_each(names, "fix", "known", True)

    def bound(self, name: str, lower: float | None = None, upper: float | None = None) -> Model:
        """Sets the bounds of a parameter that are given."""
        given = {"lower": lower, "upper": upper}
        return self._update_parameters({name: {k: v for k, v in given.items() if v is not None}}, "bound")

    def _set_each(self, names: tuple[str, ...], place: str, field: str, value: bool) -> Model:
        return self._update_parameters({name: {field: value} for name in names}, place)

    def _update_parameters(self, parameters: Mapping[str, Any], place: str) -> Model:
        return self.update(f"parameters = {_toml(parameters)}", place)

    def update(self, toml: str, name: str = "update") -> Model:
        """Takes what a model file's text says, and keeps the rest; `name` stands for the file in messages."""
        self._core.update(toml, name)
        return self

    def add_effect(self, *names: str) -> Model:
        """Adds effects of the catalogue, each with its parameters (unknown) and states.

        "torque_ripple:2" is a second one of its kind; see effect_names().
        """
        return self.update(f"effects = {_toml(names)}", "add_effect")

    def remove_effect(self, name: str) -> Model:
        """Takes an effect out again, with its parameters and states."""
        self._core.remove_effect(name)
        return self

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All parameters as they are now, in the model's order."""
        return {row[0]: Parameter(*row) for row in self._core.parameters()}

    def __getitem__(self, name: str) -> float:
        """The value of a parameter."""
        return self.parameters[name].value

    @property
    def unknowns(self) -> list[str]:
        """Names of the unknown parameters, in the order of estimates."""
        return [p.name for p in self.parameters.values() if not p.known]

    @property
    def states(self) -> list[str]:
        """Names of the states: two twists (rad), three speeds (rad/s), then those of effects."""
        return self._core.states()

    @property
    def units(self) -> list[str]:
        """Of states, then unknown parameters."""
        return self._core.units()

    @property
    def effects(self) -> list[str]:
        return self._core.effects()

    @property
    def settings(self) -> dict[str, Any]:
        """What the model file says beside parameters and effects, a table per section; change it by set()."""
        content = tomllib.loads(self.text())
        return {name: table for name, table in content.items() if name not in ("effects", "parameters")}

    def text(self) -> str:
        """The model file; from_text() reads the same numbers."""
        return self._core.text()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the model file; it takes its name only when complete."""
        self._core.save(os.fspath(path))

    def copy(self) -> Model:
        return Model(self)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self.text() == other.text()

    __hash__ = None  # type: ignore[assignment]  # it changes

    def __reduce__(self) -> tuple[Any, ...]:
        return Model.from_text, (self.text(),)

    def __repr__(self) -> str:
        effects = f", effects {', '.join(self.effects)}" if self.effects else ""
        return f"<armukf.Model: {len(self.parameters)} parameters, unknown {', '.join(self.unknowns)}{effects}>"

    def _repr_html_(self) -> str:
        rows = [(p.name, p.value, p.unit, "" if p.known else "unknown", p.lower, p.upper)
                for p in self.parameters.values()]
        return table(("parameter", "value", "unit", "", "lower", "upper"), rows,
                     f"Model, effects: {', '.join(self.effects) or 'none'}")


# What becomes a model: one to copy, the path of a model file, or None for the published arm.
ModelSource = Union[Model, str, "os.PathLike[str]", None]


def filtered(model: ModelSource, filter: str | None) -> Model:
    """A copy of the model, with another filter if there is one."""
    chosen = Model(model)
    return chosen if filter is None else chosen.set({"filter.kind": filter})
