#!/usr/bin/python3
"""Runs the examples of the manual and of the README as a reader would, and compares what they show.

    manual_examples.py PROGRAM FOLDER [PAGE...]

A page is a file of data/manual, by its name there, or README.md; all of them by default. Each has a folder of its own
in FOLDER, with `data`, `scripts` and `tests` of the source tree in it. The line before each block of shell
(console or sh) or Python says what is done with it:

    <!-- run -->                 run it; its exit status is 0
    <!-- run, exit status 2 -->
    <!-- run for 2 s -->         it still runs after that time, and is ended
    <!-- not run: WHY -->
    <!-- before: COMMAND -->     run, but not shown; what the page takes for granted

In a console block lines after `$ ` are commands, the others what they print. Those have to be printed, in this order;
`...` stands for any lines, `…` for any rest of a line. Numbers may differ by two percent.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
MANUAL = TREE / "data/manual"
LANGUAGES = ("console", "sh", "python")
MARK = re.compile(r"<!-- (run|not run|before)\b(.*?) ?-->$")
FENCE = re.compile(r"```(\w+)$")
NUMBER = re.compile(r"[-+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?")
CLOSE = 0.02  # relative; estimates differ between processors in their last digits
LONGEST_S = 600.0  # of a command; a machine may be busy


class Fault(Exception):
    """What is wrong with an example, and where."""


@dataclass
class Step:
    """A command and what it is to print, or a piece of Python."""

    line: int
    language: str
    text: str
    shown: list = field(default_factory=list)
    status: int = 0
    runs_for_s: float = 0.0


def steps_of_block(language, lines, first, mark):
    what = mark[2]
    status = int(m[1]) if (m := re.match(r", exit status (\d)$", what)) else 0
    runs_for = float(m[1]) if (m := re.match(r" for (\S+) s$", what)) else 0.0
    if what and not status and not runs_for:
        raise Fault(f"{first}: cannot read the mark 'run{what}'")
    if language != "console":
        return [Step(first + 1, language, "\n".join(lines), [], status, runs_for)]
    steps = []
    for number, line in enumerate(lines, first + 1):
        if line.startswith("$ "):
            steps.append(Step(number, "sh", line[2:], [], status, runs_for))
        elif steps and line.startswith("> "):
            steps[-1].text += "\n" + line[2:]
        elif steps:
            steps[-1].shown.append(line)
        else:
            raise Fault(f"{first}: a console block begins with `$ `")
    return steps


def steps_of(text):
    """The steps of a page in their order; a Fault where a block says not what is done with it."""
    steps, mark, lines = [], None, iter(enumerate(text.splitlines(), 1))
    for number, line in lines:
        if match := MARK.match(line):
            if match[1] == "before":
                steps.append(Step(number, "sh", match[2].removeprefix(":").strip()))
            else:
                mark = match
            continue
        if (fence := FENCE.match(line)) and fence[1] in LANGUAGES:
            block = []
            for _, inner in lines:
                if inner == "```":
                    break
                block.append(inner)
            if mark is None:
                raise Fault(f"{number}: the block says not whether it is run")
            if mark[1] == "run":
                steps += steps_of_block(fence[1], block, number, mark)
        if line.strip():
            mark = None
    return steps


def numbers_close(shown, printed):
    a, b = (float(text.replace(",", "")) for text in (shown, printed))
    last = 10.0 ** -len(shown.partition(".")[2].partition("e")[0]) if "e" not in shown else 0.0
    return abs(a - b) <= max(CLOSE * abs(a), 1.5 * last)


def line_matches(shown, printed):
    head, rest, _ = shown.partition("…")
    pattern = [re.escape(piece).replace(r"\ ", " ") for piece in NUMBER.split(" ".join(head.split()))]
    match = re.match(f"({NUMBER.pattern})".join(pattern) + ("" if rest else "$"), " ".join(printed.split()))
    return bool(match) and all(map(numbers_close, NUMBER.findall(" ".join(head.split())), match.groups()))


def missing_line(shown, printed):
    """The first line shown that was not printed after the ones before it; None if all were."""
    at = 0
    for line in shown:
        if line.strip() in ("", "..."):
            continue
        found = next((k for k in range(at, len(printed)) if line_matches(line, printed[k])), None)
        if found is None:
            return line
        at = found + 1
    return None


def environment(program):
    return {**os.environ, "PATH": f"{Path(program).resolve().parent}:{os.environ['PATH']}", "LC_ALL": "C.UTF-8",
            "PYTHONDONTWRITEBYTECODE": "1"}


def run_for_a_while(step, folder, variables):
    with subprocess.Popen(["bash", "-c", step.text], cwd=folder, env=variables, start_new_session=True,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True) as running:
        time.sleep(step.runs_for_s)
        status = running.poll()
        if status is None:
            os.killpg(running.pid, signal.SIGTERM)
        printed = running.communicate(timeout=LONGEST_S)[0]
    if status is not None:
        raise Fault(f"{step.line}: ended early, with exit status {status}\n{printed}")


def run_step(step, folder, variables):
    if step.runs_for_s:
        run_for_a_while(step, folder, variables)
        return
    command = ["bash", "-e", "-o", "pipefail", "-c", step.text]
    done = subprocess.run(command, cwd=folder, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=LONGEST_S, check=False)
    if done.returncode != step.status:
        raise Fault(f"{step.line}: exit status {done.returncode}, not {step.status}\n{step.text}\n{done.stdout}")
    if (line := missing_line(step.shown, done.stdout.splitlines())) is not None:
        raise Fault(f"{step.line}: the page shows\n{line}\nbut printed was\n{done.stdout}")


def run_python(steps, folder, variables):
    """All of a page's Python in one interpreter, as in a notebook."""
    source = "\n".join(step.text for step in steps)
    done = subprocess.run(["/usr/bin/python3", "-c", source], cwd=folder, env=variables, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=LONGEST_S, check=False)
    if done.returncode:
        raise Fault(f"{steps[0].line}: Python\n{done.stderr}")


def has_python_package(variables):
    return not subprocess.run(["/usr/bin/python3", "-c", "import armukf"], env=variables, capture_output=True,
                              check=False).returncode


def make_folder(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in ("data", "scripts", "tests"):
        (folder / name).symlink_to(TREE / name)


def run_page(name, folder, variables, with_python):
    """Runs a page's examples; how many there were."""
    path = TREE / name if name == "README.md" else MANUAL / name
    try:
        steps = steps_of(path.read_text(encoding="utf-8"))
        make_folder(folder)
        for step in steps:
            if step.language != "python":
                run_step(step, folder, variables)
        if with_python and (python := [step for step in steps if step.language == "python"]):
            run_python(python, folder, variables)
    except (Fault, subprocess.TimeoutExpired) as fault:
        raise Fault(f"{path.relative_to(TREE)}:{fault}") from None
    return len(steps)


def pages():
    return ["README.md", *sorted(p.relative_to(MANUAL).as_posix() for p in MANUAL.rglob("*.md"))]


def main(arguments):
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    program, folder, *chosen = arguments
    variables = environment(program)
    with_python = has_python_package(variables)
    if not with_python:
        print("the Python package was not built: its examples are skipped")
    faults = 0
    for page in chosen or pages():
        begun = time.monotonic()
        try:
            count = run_page(page, Path(folder).resolve() / page.removesuffix(".md"), variables, with_python)
            if count:
                print(f"{page}: {count} examples, {time.monotonic() - begun:.1f} s", flush=True)
        except Fault as fault:
            faults += 1
            print(fault, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
