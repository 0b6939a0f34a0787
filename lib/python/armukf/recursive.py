"""What recursive estimates have in common, however their samples come."""

from __future__ import annotations

from typing import Generic, TypeVar

from . import _core
from .model import Model
from .results import ParameterEstimate, parameter_table

Core = TypeVar("Core", _core.Session, _core.Track)


class Recursive(Generic[Core]):
    """A belief about states and unknown parameters, as it is now."""

    def __init__(self, core: Core, start: Model) -> None:
        self._core: Core = core
        self._names = (*start.states, *start.unknowns)

    @property
    def names(self) -> tuple[str, ...]:
        """Of what is estimated: states, then unknown parameters."""
        return self._names

    @property
    def model(self) -> Model:
        """The model with the parameters as believed now, and that belief: who starts with it goes on."""
        return Model._of(self._core.model())

    @property
    def parameters(self) -> dict[str, ParameterEstimate]:
        """Every parameter as believed now."""
        found = zip(self.model.parameters.values(), self._core.sd(), self._core.model_sd())
        return {p.name: ParameterEstimate(p.value, p.unit, p.known, float(sd), float(sd_model))
                for p, sd, sd_model in found}

    def __repr__(self) -> str:
        return f"<armukf.{type(self).__name__}: {', '.join(self._names)}>"

    def _repr_html_(self) -> str:
        return parameter_table(self.parameters, f"{type(self).__name__}, as believed now")
