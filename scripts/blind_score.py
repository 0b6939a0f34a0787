#!/usr/bin/python3
"""Lets `armukf diagnose` find effects that it does not know of, and keeps the score.

    blind_score.py --group null|large|small|pairs|foreign|all [--seeds N] [--only NAME]
    blind_score.py --calibrate [--only NAME]      sizes of the effects, into tests/blind/sizes.json

Records come from blind_plant, which shares no code with armukf. A seed also chooses arm, controller
and noise (blind_cases.py). Growth is the plain model's validation error over that on the null record
of the same seed, which is the floor; achievable is the error of a fit that is told the effect, and may
lie above the floor where that fit, from its default start, ends in a local minimum. Avoidable is what
lies between the plain model's error and the floor. The score, in Markdown, goes to standard output or
to --output. Exit status 1: a program failed.
"""

import argparse
import json
import statistics
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from blind_calibration import calibrate
from blind_cases import (CATALOGUE, FOREIGN, PAIRS, ROOT, SIZES, SURROUNDINGS, Case, Failure, Programs,
                         base, called, fitted_error, in_parallel, make_records, plain_error,
                         spellings)

SEEDS = {"null": 60, "large": 3, "small": 3, "pairs": 3, "foreign": 3}
GROWTH_OF = {"large": (2.0, float("inf")), "small": (1.2, 1.5)}


@dataclass
class Outcome:
    case: Case
    failure: str = ""
    verdict: str = ""
    effects: tuple = ()  # as added by diagnose
    named: str = ""      # yes, confused, no
    before: float = float("nan")  # validation MSE, (rad/s)^2
    after: float = float("nan")
    achievable: float = float("nan")

    plain: float = float("nan")  # of the fit without effects
    floor: float = float("nan")  # the same where nothing is missing

    @property
    def growth(self):
        return self.plain / self.floor

    @property
    def removed_percent(self):
        """Of the avoidable error."""
        return 100 * (self.before - self.after) / (self.before - self.floor)

    @property
    def made_worse(self):
        return self.after > 1.02 * self.before


def diagnosed(programs, records):
    estimation, validation = records
    return json.loads(called([programs.armukf, "diagnose", estimation, "--validate", validation,
                              *programs.diagnose_options, "--json", "-", "--quiet"],
                             programs.timeout_s))


def how_named(names, effects):
    """Whether each of the names is that of an effect added, or one it is confused with."""
    added = {base(e["name"]) for e in effects}
    confused = {base(n) for e in effects for n in e.get("confused_with", [])}
    if not names:
        return ""
    if all(base(n) in added for n in names):
        return "yes"
    return "confused" if all(base(n) in added | confused for n in names) else "no"


def achievable_error(programs, records, names):
    """Least MSE over the spellings of the names that armukf knows; nan if it knows none."""
    errors = []
    variants = [[n] for n in spellings(names[0])]
    for name in names[1:]:
        variants = [v + [n] for v in variants for n in spellings(name)]
    for variant in variants:
        try:
            errors.append(fitted_error(programs, records, variant))
        except Failure:
            continue  # a name of which armukf does not know
    return min(errors, default=float("nan"))


def tried(programs, case):
    outcome = Outcome(case)
    names = [name for name, _ in case.effects]
    with tempfile.TemporaryDirectory() as folder:
        try:
            records = make_records(programs, case.effects, case.seed, folder)
            if names:
                outcome.plain = fitted_error(programs, records)
                outcome.floor = plain_error(programs, (), case.seed)
            if names and case.group != "foreign":
                outcome.achievable = achievable_error(programs, records, names)
            result = diagnosed(programs, records)
        except Failure as failure:
            outcome.failure = str(failure).splitlines()[-1]
            return outcome
    outcome.verdict = result["verdict"]
    outcome.effects = tuple(e["name"] for e in result["effects"])
    outcome.named = how_named(names, result["effects"]) if case.group != "foreign" else ""
    outcome.before = result["before"]["validation"]["mse"]
    outcome.after = result["after"]["validation"]["mse"]
    return outcome


def chosen(names, only):
    return [n for n in names if only in (None, n, base(n))]


def cases_of(group, seeds, only, sizes):
    def size(name, kind, seed):
        return sizes[name][kind][(seed - 1) % len(SURROUNDINGS)]["size"]

    numbers = range(1, (seeds or SEEDS[group]) + 1)
    if group == "null":
        return [Case(group, (), s) for s in numbers]
    if group == "pairs":
        return [Case(group, tuple((n, size(n, "large", s)) for n in pair), s)
                for pair in PAIRS for s in numbers]
    names = chosen(FOREIGN if group == "foreign" else CATALOGUE, only)
    kind = "small" if group == "small" else "large"
    return [Case(group, ((n, size(n, kind, s)),), s) for n in names for s in numbers]


def number(value, form=".4g"):
    return format(value, form) if value == value else "–"


def row(o):
    cells = [o.case.title, " + ".join(f"{size:g}" for _, size in o.case.effects), str(o.case.seed)]
    if o.failure:
        cells += [f"failed: {o.failure}"] + [""] * 8
    else:
        cells += [", ".join(o.effects) or "nothing", o.named, o.verdict, number(o.growth, ".2f"),
                  number(o.before), number(o.after), number(o.achievable), number(o.floor),
                  number(o.removed_percent, ".0f")]
    return "| " + " | ".join(cells) + " |"


def share(part, whole):
    return f"{part} of {whole}" + (f" ({100 * part / whole:.0f} %)" if whole else "")


def named_summary(group, outcomes):
    lower, upper = GROWTH_OF.get(group, (0.0, float("inf")))
    counted = [o for o in outcomes if lower <= o.growth <= upper]
    named = sum(o.named in ("yes", "confused") for o in counted)
    lines = [f"named, or among the confused: {share(named, len(counted))}; outright "
             f"{sum(o.named == 'yes' for o in counted)}; found anything "
             f"{sum(bool(o.effects) for o in counted)}"]
    if counted:
        removed = [o.removed_percent for o in counted]
        lines.append(f"avoidable error removed: median {statistics.median(removed):.0f} %, "
                     f"least {min(removed):.0f} %, at least 80 % in "
                     f"{share(sum(r >= 80 for r in removed), len(removed))}")
    lines.append(f"validation error raised by more than 2 %: {sum(o.made_worse for o in outcomes)}")
    if len(counted) < len(outcomes):
        lines.append(f"{len(outcomes) - len(counted)} left out, growth not from {lower} to {upper}")
    return lines


def summary(group, outcomes):
    done = [o for o in outcomes if not o.failure]
    lines = [f"records: {len(outcomes)}"]
    if len(done) < len(outcomes):
        lines.append(f"failed: {len(outcomes) - len(done)}")
    if group == "null":
        alarms = sum(len(o.effects) for o in done)
        lines.append(f"effects accepted: {alarms} in {len(done)} records "
                     f"({'within' if alarms <= len(done) / 60 else 'above'} 1 in 60)")
    elif group == "foreign":
        lines.append("verdict 'model sufficient': "
                     f"{share(sum(o.verdict == 'model sufficient' for o in done), len(done))}")
        added = [o for o in done if o.effects]
        lines.append("validation error lowered where anything was added: "
                     f"{share(sum(o.after < o.before for o in added), len(added))}")
    else:
        lines += named_summary(group, done)
    return "\n".join(f"- {line}" for line in lines)


def section(group, outcomes):
    head = ("| effect | size | seed | found | named | verdict | growth | before | after | achievable "
            "| floor | avoidable removed % |\n" + "|---" * 12 + "|")
    return f"## {group}\n\n{summary(group, outcomes)}\n\n" + "\n".join([head, *map(row, outcomes)])


def options():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--group", choices=[*SEEDS, "all"], default="all")
    parser.add_argument("--calibrate", action="store_true")
    parser.add_argument("--seeds", type=int, help="records of each kind; by default "
                        + ", ".join(f"{g} {n}" for g, n in SEEDS.items()))
    parser.add_argument("--only", metavar="NAME", help="one effect; a site may be left out")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--program", default=ROOT / "build/release/bin/armukf")
    parser.add_argument("--plant", default=ROOT / "build/release/bin/blind_plant")
    parser.add_argument("--diagnose-options", default="", help="passed on, separated by blanks")
    parser.add_argument("--output", type=Path, metavar="FILE.md")
    return parser.parse_args()


def main():
    o = options()
    programs = Programs(str(o.program), str(o.plant), tuple(o.diagnose_options.split()))
    if o.only and not chosen(CATALOGUE + FOREIGN, o.only):
        sys.exit(f"blind_score.py: unknown effect '{o.only}'")
    if o.calibrate:
        calibrate(programs, chosen(CATALOGUE + FOREIGN, o.only), o.jobs)
        return 0
    sizes = json.loads(SIZES.read_text())
    groups = list(SEEDS) if o.group == "all" else [o.group]
    cases = [case for group in groups for case in cases_of(group, o.seeds, o.only, sizes)]
    outcomes = in_parallel(lambda case: tried(programs, case), cases, o.jobs)
    sections = [section(g, [x for x in outcomes if x.case.group == g]) for g in groups]
    text = "# Blind test of armukf diagnose\n\n" + "\n\n".join(sections) + "\n"
    if o.output:
        o.output.write_text(text)
    else:
        print(text, end="")
    return 1 if any(x.failure for x in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
