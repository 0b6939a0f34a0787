"""The score of blind cases as a table in Markdown."""

import statistics
from collections import Counter
from dataclasses import dataclass
from datetime import datetime, timezone

from blind_calibration import known_sizes
from blind_cases import CATALOGUE, CLASSES, COUNTED_GROWTH, Case, counts_as
from blind_programs import command_line, described_tree

LONGEST_LIST = 3
WORSE = 1.02   # of the third record's error
TELLING = 2.0  # times the floor: below, the calm record shows what noise did to the parameters
BANDS = [(1.3, 2.0), (2.0, 5.0), (5.0, 40.0)]  # of growth, for the summary


@dataclass(frozen=True)
class Outcome:
    """A case, its sizes, and what the programs answered."""
    case: Case
    effects: tuple  # of (name, size)
    answer: dict

    @property
    def failure(self):
        return self.answer.get("failure", "")

    @property
    def added(self):
        return self.answer["diagnose"]["effects"]

    @property
    def verdict(self):
        return self.answer["diagnose"]["verdict"]

    @property
    def growth(self):
        return self.answer["plain"]["validation"] / self.answer["floor"]["validation"]

    @property
    def counted(self):
        return COUNTED_GROWTH[0] <= self.growth <= COUNTED_GROWTH[1]

    def errors(self, use):
        """Of the plain model, of the completed one, and the floor."""
        return tuple(self.answer[model][use] for model in ("plain", "completed", "floor"))

    @property
    def removed_percent(self):
        """Of the avoidable error; nan where there is hardly any."""
        plain, completed, floor = self.errors("calm")
        return 100 * (plain - completed) / (plain - floor) if plain > TELLING * floor else float("nan")

    @property
    def made_worse(self):
        plain, completed, _ = self.errors("test")
        return completed > WORSE * plain

    @property
    def named(self):
        if self.case.group not in ("single", "several"):
            return ""
        how = {how_named(name, self.added) for name in self.case.names}
        return next(answer for answer in ("no", "list", "yes") if answer in how)


def told_with(effect):
    """The first names that an added effect is told with, its own and those it is confused with."""
    names = map(counts_as, [effect["name"], *effect.get("confused_with", [])])
    return list(dict.fromkeys(names))[:LONGEST_LIST]


def how_named(name, added):
    if counts_as(name) in {counts_as(e["name"]) for e in added}:
        return "yes"
    return "list" if any(counts_as(name) in told_with(e) for e in added) else "no"


def number(value, form=".3g"):
    return format(value, form) if value == value else "–"


HEAD = ("seed", "effects", "motions", "noise", "control", "growth", "found", "or", "named", "verdict",
        "validation", "third", "calm", "floor", "removed %", "s", "CPU s")
MOTIONS = {"square and multisine": "S", "random phase": "R", "moves": "M"}


def row(o):
    cells = [str(o.case.seed), " + ".join(f"{n} {s:g}" for n, s in o.effects) or "none"]
    if o.failure:
        return cells + [f"failed: {o.failure}"] + [""] * (len(HEAD) - 3)
    a, world = o.answer, o.answer["world"]
    noise, control = world["noise"], world["controller"]
    (*third, _), (*calm, floor) = o.errors("test"), o.errors("calm")
    others = dict.fromkeys(n for e in o.added for n in e["confused_with"])
    return cells + [
        MOTIONS[world["motion"]] + MOTIONS[world["test_motion"]],
        f"{noise['sensor_sd']:.2f}/{noise['sensor_pole']:.2f}/{noise['torque_sd']:.2f}",
        f"{control['proportional']:.1f}/{number(control['integral_time'] or float('nan'), '.2f')}",
        number(o.growth) if o.effects else "–", ", ".join(e["name"] for e in o.added) or "nothing",
        ", ".join(others), o.named, o.verdict,
        f"{number(a['diagnose']['before'])} → {number(a['diagnose']['after'])}",
        " → ".join(map(number, third)) + (" worse" if o.made_worse else ""),
        " → ".join(map(number, calm)), number(floor), number(o.removed_percent, ".0f"),
        f"{a['diagnose']['seconds']:.0f}", f"{a['diagnose']['cpu_seconds']:.0f}"]


def share(part, whole):
    return f"{part} of {whole}" + (f" ({100 * part / whole:.0f} %)" if whole else "")


def share_of(outcomes, law):
    return share(sum(map(law, outcomes)), len(outcomes))


def named_lines(outcomes):
    def line(title, some):
        return (f"{title}: named outright {share_of(some, lambda o: o.named == 'yes')}, at least in a "
                f"list of {LONGEST_LIST} {share_of(some, lambda o: o.named != 'no')}")

    lines = [line("all", outcomes)]
    if any(len(o.case.names) > 1 for o in outcomes):
        how = Counter(how_named(n, o.added) for o in outcomes for n in o.case.names)
        lines.append(f"of their effects one by one: outright {share(how['yes'], how.total())}, at "
                     f"least in a list {share(how['yes'] + how['list'], how.total())}")
    for low, high in BANDS:
        some = [o for o in outcomes if low <= o.growth < high]
        if some:
            lines.append(line(f"growth ×{low:g} to ×{high:g}", some))
    return lines


def removed_lines(outcomes):
    removed = [o.removed_percent for o in outcomes if o.removed_percent == o.removed_percent]
    if not removed:
        return []
    return [f"avoidable error removed: median {statistics.median(removed):.0f} %, at least 80 % in "
            f"{share(sum(r >= 80 for r in removed), len(removed))} whose plain error is {TELLING:g} "
            "times the floor or more"]


def null_lines(outcomes):
    alarms = [o for o in outcomes if o.added]
    return [f"records with an effect accepted: {share(len(alarms), len(outcomes))}; effects: "
            f"{sum(len(o.added) for o in alarms)}",
            "verdict 'model sufficient': "
            + share_of(outcomes, lambda o: o.verdict == "model sufficient")]


def foreign_lines(outcomes):
    content = [o for o in outcomes if o.verdict == "model sufficient"]
    of = Counter(o.case.names[0] for o in content)
    return [f"verdict 'model sufficient': {share(len(content), len(outcomes))}"
            + "".join(f", {n} {k}" for n, k in of.items())]


def summary(group, outcomes):
    lines = [f"records: {len(outcomes)}"]
    done = [o for o in outcomes if not o.failure]
    if len(done) < len(outcomes):
        lines.append(f"failed: {len(outcomes) - len(done)}")
    counted = [o for o in done if o.counted or group == "null"]
    if len(counted) < len(done):
        lines.append(f"not counted, growth not from ×{COUNTED_GROWTH[0]:g} to "
                     f"×{COUNTED_GROWTH[1]:g}: {len(done) - len(counted)}")
    if counted:
        of_group = {"null": null_lines, "foreign": foreign_lines}.get(group, named_lines)
        lines += of_group(counted) + (removed_lines(counted) if group != "null" else [])
        lines.append(f"third record's error more than {100 * (WORSE - 1):.0f} % above the plain "
                     f"model's: {share_of(counted, lambda o: o.made_worse)}; of them something was "
                     f"added in {sum(bool(o.added) for o in counted if o.made_worse)}")
    return "\n".join(f"- {line}" for line in lines)


def table(head, rows):
    return "\n".join("| " + " | ".join(cells) + " |" for cells in [head, ["---"] * len(head), *rows])


def by_effect(outcomes):
    """How often each effect was named."""
    rows = []
    for name in CATALOGUE:
        some = [o for o in outcomes if o.case.names == (name,) and not o.failure and o.counted]
        how = Counter(o.named for o in some)
        if some:
            rows.append([name, *map(str, (len(some), how["yes"], how["list"], how["no"]))])
    return table(["effect", "records", "outright", "in the list", "no"], rows)


def section(group, outcomes):
    parts = [f"## {group}", summary(group, outcomes)]
    if group == "single":
        parts.append(by_effect(outcomes))
    return "\n\n".join([*parts, table(HEAD, [row(o) for o in outcomes])])


def header(half, stamp, outcomes):
    done = [o.answer["diagnose"] for o in outcomes if not o.failure]
    made = "; ".join(f"{m['sizes']} by {m['version']}, tree {m['tree']}, {m['date']}"
                     for m in known_sizes()["made"])
    lines = [f"program: {stamp['version']}, hash {stamp['armukf']}; plant: hash {stamp['plant']}",
             f"tree: {described_tree()}", f"command: `{command_line()}`",
             f"date: {datetime.now(timezone.utc):%Y-%m-%d %H:%M} UTC", f"sizes: {made}"]
    for unit, of in (("s", "seconds"), ("CPU s", "cpu_seconds")):
        times = [d[of] for d in done]
        if times:
            lines.append(f"a diagnosis: median {statistics.median(times):.0f} {unit}, longest "
                         f"{max(times):.0f} {unit}")
    lines += [f"counts as {n}: {', '.join(names)}; {why}" for n, names, why in CLASSES]
    lines.append("columns: motions S square and multisine, R random phase, M moves, of the first two "
                 "records and of the third; noise: sensor's sd (rad/s), its pole, torque's sd (N·m); "
                 "control: gain (N·m·s/rad), integral time (s); errors: MSE in (rad/s)², plain → "
                 "completed, on the second record, the third, and the third without noise (calm)")
    return f"# Blind test of armukf diagnose, {half} half\n\n" + "\n".join(f"- {x}" for x in lines)
