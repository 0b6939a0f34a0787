#!/usr/bin/python3
"""Lets `armukf diagnose` find effects that it does not know of, and keeps the score.

    blind_score.py --half tuning|score --cache FOLDER --output FILE.md     the whole table of a half
    blind_score.py --half … --cache FOLDER --shard 2/8                     a part of it
    blind_score.py --half … --calibrate                                    sizes of its effects

Records come from blind_plant, which shares no code with armukf. Each case has a seed of its own, and
the seed draws arm, noise, controller and motions (blind_cases.py); sizes lie in tests/blind/sizes.json
(blind_calibration.py). Whoever sets a threshold looks at the tuning half only; the claim is made on the
score half, whose seeds and arms nothing has seen.

A case makes three records. `diagnose` is given two, and what is known of the arm: friction at the
motor and J. The third, whose motion may be of another kind, judges what it ends with: made worse is
what errs more there than the plain model, which `fit` finds on the first record from the true values
on. Torque noise adds up to slow errors that a wrong effect may happen to follow, on a third record as
on any other; how much of the avoidable error is gone is therefore seen on the third record made once
more without noise. Avoidable is what lies between the plain model's error on it and the same of the
seed without the effect, the floor.

Growth is the plain model's validation error over the floor. `named`: yes, if each effect is among
those added; list, if it is at least among the first three names that one of them is told with, its own
and those it is confused with; names of one class (blind_cases.CLASSES) count as one.

What a case gave is kept in the cache, and found again there only for the same programs (by hash),
sizes and options; so a run may be cut short, go on, or be cut in shards, a process each, and then
put together by one without --shard. Exit status 1: a program failed.
"""

import argparse
import fcntl
import hashlib
import json
import sys
import tempfile
from pathlib import Path

from blind_calibration import calibrate, known_sizes, sized
from blind_cases import CATALOGUE, FOREIGN, GROUPS, HALVES, cases_of, counts_as
from blind_programs import (ROOT, Failure, Programs, called, error, in_parallel, make_records,
                            plain_errors, told)
from blind_table import Outcome, header, section


def diagnosed(programs, records, known, model):
    answer = called([programs.armukf, "diagnose", records["estimation"], "--validate",
                     records["validation"], *known, *programs.diagnose_options, "--save", model,
                     "--json", "-", "--quiet"], programs.timeout_s)
    found = json.loads(answer.out)
    return {"verdict": found["verdict"],
            "effects": [{"name": e["name"], "confused_with": e.get("confused_with", []),
                         "parameters": {n: p["value"] for n, p in e.get("parameters", {}).items()}}
                        for e in found["effects"]],
            "before": found["before"]["validation"]["mse"],
            "after": found["after"]["validation"]["mse"],
            "seconds": round(answer.seconds, 2), "cpu_seconds": round(answer.cpu_seconds, 2)}


def answered(programs, case, effects):
    """What a case gives; a failure too is an answer."""
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as null_folder:
        try:
            records, truth = make_records(programs, effects, case.seed, folder)
            plain = plain_errors(programs, records, truth)
            floor = plain
            if effects:
                floor = plain_errors(programs, *make_records(programs, (), case.seed, null_folder))
            model = Path(folder, "completed.toml")
            found = diagnosed(programs, records, told(truth), model)
            return {"world": truth, "plain": plain, "floor": floor, "diagnose": found,
                    "completed": {use: error(programs, records[use], model)
                                  for use in ("test", "calm")}}
        except Failure as failure:
            return {"failure": str(failure).splitlines()[-1]}


class Cache:
    """Answers as JSON lines in a folder, which several processes may share; failures are not kept."""

    def __init__(self, folder):
        self.path = folder and Path(folder) / "answers.jsonl"
        self.answers = {}
        if folder:
            Path(folder).mkdir(parents=True, exist_ok=True)
            if self.path.exists():
                for line in self.path.read_text().splitlines():
                    kept = json.loads(line)
                    self.answers[kept["key"]] = kept["answer"]

    def answer(self, asked, find):
        key = hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:32]
        if key not in self.answers:
            self.answers[key] = find()
            if self.path and "failure" not in self.answers[key]:
                line = json.dumps({"key": key, "asked": asked, "answer": self.answers[key]})
                with self.path.open("a") as file:
                    fcntl.flock(file, fcntl.LOCK_EX)
                    file.write(line + "\n")
        return self.answers[key]


def tried(programs, case, effects, cache, stamp):
    def find():
        answer = answered(programs, case, effects)
        if programs.stamp() != stamp:
            raise SystemExit("blind_score.py: a program has been replaced under the score")
        return answer

    asked = {**stamp, "options": programs.diagnose_options, "seed": case.seed, "effects": effects}
    return Outcome(case, effects, cache.answer(asked, find))


def chosen(cases, only):
    return [c for c in cases if only is None or only in {*c.names, *map(counts_as, c.names)}]


def shard_of(text):
    part, whole = map(int, text.split("/"))
    if not 1 <= part <= whole:
        raise ValueError
    return part, whole


def options():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--half", choices=HALVES, required=True)
    parser.add_argument("--group", choices=[*GROUPS, "all"], default="all")
    parser.add_argument("--only", metavar="NAME", help="cases of one effect; a site may be left out")
    parser.add_argument("--shard", type=shard_of, default=(1, 1), metavar="I/N")
    parser.add_argument("--calibrate", action="store_true")
    parser.add_argument("--cache", type=Path, metavar="FOLDER")
    parser.add_argument("--jobs", type=int, default=2, help="cases at a time")
    parser.add_argument("--program", default=ROOT / "build/release/bin/armukf")
    parser.add_argument("--plant", default=ROOT / "build/release/bin/blind_plant")
    parser.add_argument("--diagnose-options", default="", help="passed on, separated by blanks")
    parser.add_argument("--output", type=Path, metavar="FILE.md")
    return parser.parse_args()


def main():
    o = options()
    programs = Programs(str(o.program), str(o.plant), tuple(o.diagnose_options.split()))
    if o.only and o.only not in {*CATALOGUE, *FOREIGN, *map(counts_as, CATALOGUE)}:
        sys.exit(f"blind_score.py: unknown effect '{o.only}'")
    groups = list(GROUPS) if o.group == "all" else [o.group]
    part, whole = o.shard
    cases = chosen([c for g in groups for c in cases_of(o.half, g)], o.only)[part - 1::whole]
    if o.calibrate:
        calibrate(programs, cases, o.jobs)
        return 0
    stamp, cache, sizes = programs.stamp(), Cache(o.cache), known_sizes()["sizes"]
    outcomes = in_parallel(
        lambda case: tried(programs, case, sized(case, sizes), cache, stamp), cases, o.jobs)
    sections = [section(g, [x for x in outcomes if x.case.group == g]) for g in groups]
    text = "\n\n".join([header(o.half, stamp, outcomes), *sections]) + "\n"
    if o.output:
        o.output.write_text(text)
    else:
        print(text, end="")
    return 1 if any(x.failure for x in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
