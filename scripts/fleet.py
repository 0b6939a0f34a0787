#!/usr/bin/python3
"""Fits, watches or diagnoses the records of many arms: which arm has what, since when, how sure; worst first.

    fleet.py FOLDER|LIST.csv [--job fit|watch|diagnose] [-o NAME] [-- OPTION...]

FOLDER holds records whose names tell arm and date, ARM_2026-03-01.csv or ARM_2026-03-01T10-00-00.csv, or as
--names says. LIST.csv is a table with the columns file and, unless the names tell them, arm and date (ISO
8601, UTC); paths are seen from where the table lies. What comes after -- goes to armukf, for example
`-- --free-initial all`. --models FOLDER: arms that have a model of their own there, ARM.toml, are given it.

    fit         armukf fit: what a parameter has become from record to record, a step or a drift
    watch       armukf estimate --watch: what changed during a record (`event`), and from record to record
    diagnose    armukf diagnose: what the model lacks (`effect`), since the first record that shows it

Writes NAME.csv and NAME.html. A row of the table is a thing found, the arm with the largest one (in
deviations) first; `t` is the onset by the record's own clock, `sd` a deviation of the change, `sure` the
probability that it is no chance, given all that was looked at (of an event: that it is what it is called).
Arms without any, and records that failed, have a row as well.

What is done is kept in NAME.state.jsonl (--state), and counts as long as program, options and the contents of
record and model are the same; failures are tried again. Exit status 1: a record failed; the others are told.
"""

import argparse
import csv
import json
import re
import sys
import tempfile
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path

import fleet_page
import stamps
import sweeps
from findings import COLUMNS, findings_of, rows_of
from sweeps import Trouble

NAMES = r"(?P<arm>.+)_(?P<date>\d{4}-\d\d-\d\d(T\d\d-\d\d(-\d\d)?)?)\.csv"
COMMANDS = {"fit": ["fit", "--threads", "1"], "watch": ["estimate", "--watch"],
            "diagnose": ["diagnose", "--threads", "1"]}


@dataclass
class Record:
    """A record of an arm, and what armukf found in it, or why not."""
    file: str  # as the user calls it
    path: Path
    arm: str = ""
    date: datetime | None = None
    error: str = ""
    found: dict = field(default_factory=dict)


def moment(text):
    """The date that a name or a table tells."""
    date, _, time = text.strip().partition("T")
    found = datetime.fromisoformat(f"{date}T{time.replace('-', ':', 2)}" if re.match(r"\d\d-", time) else text.strip())
    return found.astimezone(timezone.utc).replace(tzinfo=None) if found.tzinfo else found


def told(record, arm, date, source):
    """The record with its arm and date, or with the reason why they are not known."""
    record.arm = arm
    try:
        record.date = moment(date)
    except ValueError:
        record.error = f"{record.file}: {source}: '{date}' is no date"
    return record


def named(file, path, names):
    match = names.fullmatch(path.name)
    if not match:
        return Record(file, path, error=f"{file}: its name does not tell arm and date; see --names")
    return told(Record(file, path), match["arm"], match["date"], "name")


def listed(table, names):
    """The records of a table."""
    try:
        with open(table, newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(line for line in file if line.strip() and not line.startswith("#")))
    except (OSError, UnicodeDecodeError) as error:
        raise Trouble(f"{table}: {getattr(error, 'strerror', None) or 'is no table'}") from error
    if rows and rows[0].get("file") is None:
        raise Trouble(f"{table}: no column file")
    records = []
    for row in rows:
        file, arm, date = (row.get(column) or "" for column in ("file", "arm", "date"))
        path = table.parent / file
        records.append(told(Record(file, path), arm, date, table.name) if arm and date else named(file, path, names))
    return records


def records_of(place, names, own_table=""):
    """All records, arm by arm in order of time; the table that an earlier run has left among them is none."""
    try:
        names = re.compile(names)
    except re.error as error:
        raise Trouble(f"--names: {error}") from error
    if not {"arm", "date"} <= set(names.groupindex):
        raise Trouble("--names: needs the groups (?P<arm>...) and (?P<date>...)")
    place = Path(place)
    if place.is_dir():
        paths = [path for path in sorted(place.glob("*.csv")) if path.resolve() != Path(own_table).resolve()]
        records = [named(path.name, path, names) for path in paths]
    else:
        records = listed(place, names)
    if not records:
        raise Trouble(f"{place}: holds no records")
    return sorted(records, key=lambda r: (r.arm, r.date or datetime.min, r.file))


def item_of(record, o, program):
    """What a worker is asked for. It holds all that the answer depends on, so that an answer that is kept
    counts for nothing else."""
    path = str(record.path.resolve())
    model = Path(o.models, f"{record.arm}.toml").resolve() if o.models else None
    words = [*COMMANDS[o.job], path, *(["--model", str(model)] if model and model.is_file() else []), *o.options]
    return {**program, "record": path, "file": record.file, "words": words,
            "contents": stamps.hash_of(word for word in words if word.startswith("/") and Path(word).is_file())}


def answered(item):
    """What armukf finds in a record, or what it complains about."""
    with tempfile.TemporaryDirectory() as folder:
        events = Path(folder, "events.jsonl")
        words = [*item["words"], *(["--events", events] if "--watch" in item["words"] else [])]
        try:
            found = sweeps.armukf(item["program"], *words)
        except Trouble as trouble:
            said = str(trouble).replace(item["record"], item["file"])
            return {"error": said if said.startswith(item["file"]) else f"{item['file']}: {said}"}
        told_events = events.read_text() if events.exists() else ""
    fit = found.get("simulation") or found.get("after", {}).get("estimation") or found
    parameters = [found.get("parameters", {}), *(effect["parameters"] for effect in found.get("effects", []))]
    return {"parameters": {n: [p["value"], p["sd"], p["unit"]] for group in parameters for n, p in group.items()},
            "fit_percent": fit["fit_percent"], "events": told_events, "effects": found.get("effects", []),
            "unexplained": found.get("unexplained", [])}


def options_of():
    words = sys.argv[1:]
    cut = words.index("--") if "--" in words else len(words)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", metavar="FOLDER|LIST.csv")
    parser.add_argument("--job", choices=COMMANDS, default="fit")
    parser.add_argument("--names", metavar="REGEX", default=NAMES, help="of the files' names, with groups named "
                        "arm and date; by default %(default)s")
    parser.add_argument("--models", metavar="FOLDER", help="holds model files of some arms, ARM.toml")
    parser.add_argument("-o", "--output", metavar="NAME", default="fleet", help="of table, page and state")
    sweeps.add_options(parser)
    o = parser.parse_args(words[:cut])
    # Workers may run elsewhere: files are named by whole paths.
    o.options = [str(Path(word).resolve()) if Path(word).is_file() else word for word in words[cut + 1:]]
    if o.models and not Path(o.models).is_dir():
        raise Trouble(f"{o.models}: is no folder")
    if not Path(o.program).is_file():
        raise Trouble(f"{o.program}: no such program")
    return o


def answer_all(records, o):
    """Puts into every record what was found in it."""
    program = {"program": str(Path(o.program).resolve()), "stamp": stamps.hash_of(stamps.files_of(o.program))}
    asked = [record for record in records if not record.error]
    ledger = sweeps.Ledger(o.state or f"{o.output}.state.jsonl")
    ledger.results = {key: result for key, result in ledger.results.items() if "error" not in result}
    with sweeps.pool(o.workers, o.scheduler) as pool:
        answers = pool.map(answered, [item_of(record, o, program) for record in asked], ledger, "records")
    for record, answer in zip(asked, answers):
        record.error, record.found = answer.get("error", ""), answer


def main():
    o = options_of()
    records = records_of(o.records, o.names, f"{o.output}.csv")
    answer_all(records, o)
    findings = findings_of(records)
    rows = rows_of(records, findings)
    with sweeps.whole_file(f"{o.output}.csv") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(rows)
    with sweeps.whole_file(f"{o.output}.html") as file:
        file.write(fleet_page.page(o.job, records, findings, rows))
    sweeps.write_json(o.json, [{"file": r.file, "arm": r.arm, "date": r.date and r.date.isoformat(), **r.found,
                                "error": r.error} for r in records])
    broken = [record for record in records if record.error]
    for record in broken:
        print(f"fleet.py: {record.error}", file=sys.stderr)
    return 1 if broken else 0


if __name__ == "__main__":
    sweeps.run_script(main)
