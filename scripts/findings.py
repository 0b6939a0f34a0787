"""What the records of a fleet tell of each arm, worst first."""

from dataclasses import dataclass
from datetime import datetime
from itertools import groupby

from scipy.special import ndtri

from events import events_in
from style import title_of
from trends import change_of, strays

CHANCE = 0.01  # a change that is likelier by chance, given all that was looked at, is none
COLUMNS = ["arm", "what", "how", "since", "t", "from", "to", "sd", "unit", "percent", "size", "sure", "records", "note"]


def figure(number, digits=6):
    """JSON says null of a number that is not finite."""
    return "" if number is None else f"{number:.{digits}g}"


def deviations(change, sd):
    return abs(change) / sd if sd else 0.0


@dataclass(frozen=True)
class Finding:
    """A thing that an arm has: a step or drift of a parameter, an event during a record, an effect."""
    arm: str
    what: str
    how: str
    since: datetime
    size: float                 # in deviations
    sure: float | None
    start: float | None = None
    end: float | None = None
    sd: float | None = None
    unit: str = ""
    t: float | None = None      # s, of an event, by the record's clock
    records: str = ""           # how many show it
    note: str = ""

    @property
    def percent(self):
        return 100 * (self.end / self.start - 1) if self.start and self.end is not None else None


def by_arm(records):
    """Arm to those of its records that told something, in order of time."""
    good = [record for record in records if not record.error]
    return {arm: list(group) for arm, group in groupby(good, key=lambda r: r.arm)}


def series_of(records):
    """Parameter to (date, value, deviation, unit) of each record that determines it."""
    series = {}
    for record in records:
        for name, (value, sd, unit) in record.found["parameters"].items():
            if value is not None and sd:
                series.setdefault(name, []).append((record.date, value, sd, unit.removeprefix("-")))
    return series


def without_strays(points):
    alone = strays([p[1] for p in points], [p[2] for p in points])
    return [point for point, stray in zip(points, alone) if not stray]


def days(dates):
    return [(date - dates[0]).total_seconds() / 86400 for date in dates]


def changes(arm, records, looks):
    for name, points in series_of(records).items():
        points = without_strays(points)
        dates, values, sds, units = zip(*points)
        change = change_of(days(dates), values, sds, looks)
        if change and change.p < CHANCE:
            yield Finding(arm, name, change.how, dates[change.begins], change.size, 1 - change.p, change.start,
                          change.end, change.sd, units[-1], records=f"{len(points) - change.begins} of {len(points)}")


def events(arm, records):
    for record in records:
        for e in events_in(record.found["events"]):
            unit = record.found["parameters"].get(e["what"], ["", "", ""])[2].removeprefix("-")
            others = f"or {', '.join(e['also_possible'])}" if e["also_possible"] else ""
            size = deviations((e["to"] or 0.0) - (e["from"] or 0.0), e["sd"])
            yield Finding(arm, e["what"], "event", record.date, size, e["p"], e["from"], e["to"], e["sd"], unit,
                          e["onset"], note=others)


def size_of(p):
    """As many deviations as are as unlikely."""
    return float(-ndtri(max(p, 1e-300) / 2))


def effects(arm, records):
    """Of those of one name the last one tells values, the first one the date."""
    found = {}
    for record in records:
        for effect in record.found["effects"]:
            found.setdefault(title_of(effect), []).append((record.date, effect))
    for name, cases in found.items():
        effect = cases[-1][1]
        notes = [f"{n} = {figure(p['value'], 4)} ± {figure(p['sd'], 2)} {p['unit']}"
                 for n, p in effect["parameters"].items()]
        if effect["confused_with"]:
            notes.append(f"or {', '.join(effect['confused_with'])}")
        yield Finding(arm, name, "effect", cases[0][0], size_of(effect["p_value"]), 1 - effect["p_value"],
                      records=f"{len(cases)} of {len(records)}", note="; ".join(notes))
    left = [(record.date, record.found["unexplained"]) for record in records if record.found["unexplained"]]
    if left:
        yield Finding(arm, "unexplained", "rest", left[0][0], 0.0, None, records=f"{len(left)} of {len(records)}",
                      note="; ".join(left[-1][1]))


def findings_of(records):
    """Of all arms, the arm with the largest one first."""
    arms = by_arm(records)
    looks = sum(len(points) > 1 for own in arms.values() for points in series_of(own).values())
    of_arm = []
    for arm, own in arms.items():
        told = list(events(arm, own))
        said = {(f.what, f.since) for f in told}
        told += [f for f in changes(arm, own, looks) if (f.what, f.since) not in said]
        told += effects(arm, own)
        of_arm.append(sorted(told, key=lambda f: (-f.size, f.what, f.since)))
    of_arm.sort(key=lambda own: (-own[0].size, own[0].arm) if own else (0, ""))
    return [finding for own in of_arm for finding in own]


def day(date):
    """As short as it can be said."""
    return date.isoformat().removesuffix("T00:00:00") if date else ""


def rows_of(records, findings):
    """The table: what was found, records that failed, arms of which there is nothing to tell."""
    rows = [{"arm": f.arm, "what": f.what, "how": f.how, "since": day(f.since), "t": figure(f.t),
             "from": figure(f.start), "to": figure(f.end), "sd": figure(f.sd), "unit": f.unit,
             "percent": figure(f.percent), "size": figure(f.size), "sure": figure(f.sure), "records": f.records,
             "note": f.note} for f in findings]
    rows += [{"arm": r.arm, "what": "failed", "since": day(r.date), "note": r.error} for r in records if r.error]
    told = {f.arm for f in findings}
    rows += [{"arm": arm, "what": "nothing", "records": str(len(own))} for arm, own in by_arm(records).items()
             if arm not in told]
    return rows
