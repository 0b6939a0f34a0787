#!/usr/bin/python3
"""Makes the sources of the manual's pages, for Sphinx: scripts/manual calls it.

    manual_pages.py PROGRAM EXAMPLES OUTPUT

Takes data/manual, puts in what the program says of itself where a page has `<!-- generated: ... -->`, and the pictures
that the examples have drawn (manual_examples.py PROGRAM EXAMPLES). A page whose lists do not fit the program's is a fault.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from program_help import help_of

TREE = Path(__file__).resolve().parent.parent
MANUAL = TREE / "data/manual"
GENERATED = re.compile(r"^<!-- generated: (\w+) ?(\w*) -->$", re.MULTILINE)
COMMENT = re.compile(r"^<!-- .*? -->\n", re.MULTILINE)
UNIT = re.compile(r"^(\w+) = \{.*\}  # (.*)$", re.MULTILINE)
SPECIAL = re.compile(r"([\\*_`\[\]<>$|~])")


class Fault(Exception):
    pass


def said(program, *words, status=0, folder=None):
    done = subprocess.run([program, *words], capture_output=True, text=True, check=False, cwd=folder)
    if done.returncode != status:
        raise Fault(f"armukf {' '.join(words)}: exit status {done.returncode}: {done.stderr}")
    return done.stdout or done.stderr


def escaped(text):
    return SPECIAL.sub(r"\\\1", text)


def command_page(program, command):
    said = help_of(program, command)
    if said is None or not said.sections.get("options"):
        raise Fault(f"armukf {command} --help: no options")
    lines = [f"({command})=", f"## {command}", "", escaped(" ".join(said.before).strip()) + ".", "", "```text", said.usage,
             "```", ""]
    for entries in said.sections.values():
        for names, text in entries:
            lines += [f"`{' '.join(names.split())}`", f": {escaped(text)}", ""]
    after = " ".join(line.strip() for line in said.after if line.strip())
    return "\n".join([*lines, escaped(after), ""])


def commands(program, _):
    return "\n".join(command_page(program, command) for command, _ in help_of(program).sections["subcommands"])


def effect_names(program):
    listed = said(program, "simulate", "-o", "-", "--effect", "?", status=2)
    return listed.partition("known are: ")[2].strip().split(", ")


def number(value):
    return "–" if abs(value) == float("inf") else f"{value:g}"


def parameter_table(program, effect):
    """The parameters and states that a model has by the effect, as the program writes and prints them."""
    with tempfile.TemporaryDirectory() as folder:
        model = ["--effect", effect, "--save", "model.toml", "--quiet"]
        said(program, "simulate", "-o", "record.csv", "--samples", "2000", *model, folder=folder)
        text = (Path(folder) / "model.toml").read_text(encoding="utf-8")
        rows = said(program, "record.csv", "--effect", effect, "--quiet", folder=folder)
    arm = tomllib.loads((TREE / "data/arm.toml").read_text(encoding="utf-8"))["parameters"]
    units = dict(UNIT.findall(text))
    lines = [f"| `{name}` | {escaped(units[name])} | {number(p['lower'])} to {number(p['upper'])} | "
             f"{number(p['scale'])} |"
             for name, p in tomllib.loads(text)["parameters"].items() if name not in arm]
    columns = rows.split("\n", 1)[0].split(",")
    states = columns[columns.index("speed_arm") + 1:]
    parameters = tomllib.loads(text)["parameters"]
    states = [name for name in states if not name.endswith("_sd") and name not in parameters]
    table = ["| parameter | unit | bounds | typical size |", "|---|---|---|---|", *lines, ""] if lines else []
    return "\n".join([*table, f"States: {', '.join(f'`{s}`' for s in states)}." if states else ""])


MAKERS = {"commands": commands, "effect": parameter_table}


def check_effects(program, text):
    told = [name for kind, name in GENERATED.findall(text) if kind == "effect"]
    known = effect_names(program)
    if sorted(told) != sorted(known):
        raise Fault(f"the effects of the page and of the program differ: {sorted(set(told) ^ set(known))}")


def page(program, text, tree):
    """A page's text; TREE/ in it becomes the source tree, as Sphinx reaches it from its own sources."""
    if "<!-- generated: effect" in text:
        check_effects(program, text)
    text = GENERATED.sub(lambda match: MAKERS[match[1]](program, match[2]), text)
    return COMMENT.sub("", text).replace("TREE/", f"/{tree}/")


def main(arguments):
    if len(arguments) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    program, examples, output = str(Path(arguments[0]).resolve()), Path(arguments[1]), Path(arguments[2])
    shutil.rmtree(output, ignore_errors=True)
    shutil.copytree(MANUAL, output)
    pictures = output / "pictures"
    pictures.mkdir()
    for picture in examples.rglob("*.png"):  # which does not follow the links to the source tree
        shutil.copyfile(picture, pictures / picture.name)
    for picture in (TREE / "data/pictures").glob("*.png"):
        shutil.copyfile(picture, pictures / picture.name)
    tree = os.path.relpath(TREE, output)
    for source in output.rglob("*.md"):
        try:
            source.write_text(page(program, source.read_text(encoding="utf-8"), tree), encoding="utf-8")
        except Fault as fault:
            print(f"{source.relative_to(output)}: {fault}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
