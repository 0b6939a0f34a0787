"""On-line and batch estimation of a flexible robot joint, and of what its model lacks.

    import armukf

    record = armukf.simulate(sensor_noise=0.05).samples   # or armukf.read_record("run.csv")
    session = armukf.Session(armukf.Model())
    rows = session.run(record)                             # every sample: states, parameters, deviations
    print(session.parameters["k_a"])

A record is a NumPy array of float64, shape (n, 3) in C order, a row per sample: t (s), u (motor torque, N.m,
held until the next sample) and y (motor speed, rad/s; NaN where the measurement is missing). Times rise.
Where a function takes a record, the path of a CSV file with columns t, u and y will do as well.

SI units and radians throughout. A deviation (sd) is one standard deviation, a fit is
100 (1 - |y - y_hat| / |y - mean y|) percent. What the caller gets wrong raises InputError, a ValueError, in
the words of the program.
"""

from ._core import InputError, processor, version as __version__
from .jobs import (compare, diagnose, estimate, evaluate, fit, read_record, score, simulate, smooth,
                   start_from_frequency_response, start_from_slow_motion)
from .model import Model, Parameter, effect_names
from .results import (Candidate, Comparison, ComparedParameter, Consistency, Diagnosis, Effect, Estimate,
                      Estimates, EstimateSummary, Evaluation, Experiment, Fit, Innovation, InitialState,
                      Measures, ParameterEstimate, SimulatedExperiment, SimulationFit, Smoothed, Status)
from .session import Session
from .track import Fate, FateCounts, Track

InputError.__module__ = __name__

__all__ = [
    "Candidate", "ComparedParameter", "Comparison", "Consistency", "Diagnosis", "Effect", "Estimate",
    "EstimateSummary", "Estimates", "Evaluation", "Experiment", "Fate", "FateCounts", "Fit", "InitialState",
    "Innovation", "InputError", "Measures", "Model", "Parameter", "ParameterEstimate", "Session",
    "SimulatedExperiment", "SimulationFit", "Smoothed", "Status", "Track", "__version__", "compare", "diagnose",
    "effect_names", "estimate", "evaluate", "fit", "processor", "read_record", "score", "simulate", "smooth",
    "start_from_frequency_response", "start_from_slow_motion",
]
