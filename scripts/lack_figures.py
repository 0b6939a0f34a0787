#!/usr/bin/python3
"""How often `estimate` says that a model lacks something, where it does and where it does not.

    lack_figures.py                    the scored half of the blind cases, every size that is known
    lack_figures.py --half tuning      the half on which thresholds are set

Cases, sizes and records are those of blind_score.py (tests/blind): an arm of its own each, its friction
and total inertia known, one pass over the estimation record of 10 s. An effect counts as visible from a
growth on: the validation error of the plain fit over that without the effect. Exit status 1: of complete
models more than 5 % are said to lack something, or of those whose error doubles less than 95 %.
"""

import argparse
import json
import tempfile
from pathlib import Path

import blind_cases
import sweeps
from blind_calibration import key, known_sizes, sized
from blind_programs import called, in_parallel, told
from recursive_figures import Checks
from sweeps import ROOT

TESTS = ("friction", "angle", "springs", "gaps", "modes")


def trial(options, case, sizes):
    """What the innovations of one case look like."""
    with tempfile.TemporaryDirectory() as folder:
        record, truth = Path(folder, "record.csv"), Path(folder, "truth.json")
        effects = [part for name, size in sized(case, sizes) for part in ("--effect", f"{name}={size!r}")]
        called([options.plant, "--seed", case.seed, *effects, "--estimation", record, "--truth", truth], 60)
        arm = json.loads(truth.read_text())
        return sweeps.armukf(options.program, "estimate", record, "--filter", options.filter, *told(arm))["innovation"]


def row(case, growth, innovation):
    small = [name for name in TESTS if innovation["torque_tests"][name] < 1e-3]
    return f"{case.names[0]:24} {case.seed}  x{growth:5.1f}  " + \
        ("lacks" if innovation["model_lacks"] else "-    ") + f"  {' '.join(small)}"


def visible(options, sizes):
    """The cases whose size is known and grows far enough, of effects of the catalogue."""
    for case in blind_cases.cases_of(options.half, "single"):
        if key(case, 0) in sizes and sizes[key(case, 0)]["growth"] >= options.growth:
            yield case


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(sweeps.PROGRAM))
    parser.add_argument("--plant", default=str(ROOT / "build/release/bin/blind_plant"))
    parser.add_argument("--filter", default="ukf")
    parser.add_argument("--half", choices=blind_cases.HALVES, default="score")
    parser.add_argument("--growth", type=float, default=2.0, help="from which an effect counts")
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args()
    sizes = known_sizes()["sizes"]
    nulls = blind_cases.cases_of(options.half, "null")
    cases = list(visible(options, sizes))
    results = in_parallel(lambda case: trial(options, case, sizes), [*nulls, *cases], options.workers)
    alarms = sum(r["model_lacks"] for r in results[:len(nulls)])
    found = sum(r["model_lacks"] for r in results[len(nulls):])
    for case, innovation in zip(cases, results[len(nulls):]):
        print(row(case, sizes[key(case, 0)]["growth"], innovation))
    checks = Checks()
    checks.expect(alarms <= 0.05 * len(nulls),
                  f"complete models said to lack something: {alarms} of {len(nulls)} (5 %)")
    checks.expect(found >= 0.95 * len(cases),
                  f"effects of growth {options.growth:g} and more said to be lacking: {found} of {len(cases)} (95 %)")
    return 1 if checks.missed else 0


if __name__ == "__main__":
    sweeps.run_script(main)
