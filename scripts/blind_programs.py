"""The programs that blind_score.py lets answer, and what is asked of them."""

import json
import os
import shlex
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from stamps import digest_of, files_of, hash_of

ROOT = Path(__file__).resolve().parent.parent

RECORDS = ("estimation", "validation", "test")
KNOWN = ["Fv", "Fc", "Fcs", "alpha", "beta", "J"]  # of an arm; its owner has measured them
INITIAL = ["--free-initial", "all"]  # twists are not zero when a record of an arm in motion begins


@dataclass(frozen=True)
class Programs:
    armukf: str
    plant: str
    diagnose_options: tuple = ()
    timeout_s: float = 3600.0

    def stamp(self):
        """The version that armukf gives, and a hash of armukf with its library and of the plant."""
        return {"version": called([self.armukf, "--version"], 60).out.strip(),
                "armukf": hash_of(files_of(self.armukf)), "plant": digest_of(self.plant).hex()[:16]}


@dataclass(frozen=True)
class Answer:
    out: str
    seconds: float
    cpu_seconds: float


class Failure(Exception):
    """A program that did not answer."""


def called(command, timeout_s):
    """Its answer; the processor time is that of this process alone, whatever runs beside it."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = time.monotonic()
        process = subprocess.Popen([str(part) for part in command], stdout=out, stderr=err)
        late = threading.Event()
        timer = threading.Timer(timeout_s, lambda: (late.set(), process.kill()))
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.monotonic() - begin
        if late.is_set():
            raise Failure("timeout")
        out.seek(0)
        err.seek(0)
        if process.returncode != 0:
            raise Failure(err.read().decode().strip() or f"exit status {process.returncode}")
        return Answer(out.read().decode(), seconds, usage.ru_utime + usage.ru_stime)


def largest_sizes(programs):
    """Name to (typical, largest) size, as the plant has them."""
    rows = [line.split() for line in called([programs.plant, "--effects"], 60).out.splitlines()]
    return {name: (float(typical), float(largest)) for name, _, typical, largest in rows}


def make_records(programs, effects, seed, folder):
    """Paths of the records of the arm of that seed with these (name, size), and what is true of it.
    `calm` is the test record once more, without any noise."""
    records = {use: Path(folder, f"{use}.csv") for use in (*RECORDS, "calm")}
    truth = Path(folder, "truth.json")
    command = [programs.plant, "--seed", seed]
    for name, size in effects:
        command += ["--effect", f"{name}={size!r}"]
    noisy = [part for use in RECORDS for part in (f"--{use}", records[use])]
    called([*command, *noisy, "--truth", truth], programs.timeout_s)
    called([*command, "--noise-factor", 0, "--test", records["calm"]], programs.timeout_s)
    return records, json.loads(truth.read_text())


def settings(values):
    return [part for name, value in values.items() for part in ("--set", f"{name}={value!r}")]


def told(truth):
    """The options with which armukf hears what is known of the arm."""
    return settings({name: truth["arm"][name] for name in KNOWN})


def error(programs, record, model):
    """MSE of the model on the record, its initial states fitted."""
    answer = called([programs.armukf, "evaluate", record, *INITIAL, "--model", model, "--json", "-",
                     "--quiet"], programs.timeout_s)
    return json.loads(answer.out)["experiments"][0]["mse"]


def plain_errors(programs, records, truth):
    """MSE on each record of the model without effects that fits the first one. The search begins at
    the true values, so that no local minimum far from them is taken for the least."""
    model = records["estimation"].with_name("plain.toml")
    called([programs.armukf, "fit", records["estimation"], *INITIAL, *settings(truth["arm"]), "--save",
            model, "--quiet"], programs.timeout_s)
    return {use: error(programs, path, model) for use, path in records.items()}


def described_tree():
    git = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], capture_output=True,
                         text=True)
    return git.stdout.strip() or "unknown"


def command_line():
    """As typed, but for where on this machine things lie."""
    def shown(part):
        if not part.startswith("/"):
            return part
        return os.path.relpath(part, ROOT) if Path(part).is_relative_to(ROOT) else Path(part).name

    script, *rest = sys.argv
    return shlex.join([os.path.relpath(Path(script).resolve(), ROOT), *map(shown, rest)])


def in_parallel(job, items, jobs):
    """The answers in the order of the items; a line of progress on a terminal."""
    answers = []
    with ThreadPoolExecutor(jobs) as pool:
        for answer in pool.map(job, items):
            answers.append(answer)
            if sys.stderr.isatty():
                print(f"\r{len(answers)} of {len(items)}", end="", file=sys.stderr, flush=True)
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    return answers
