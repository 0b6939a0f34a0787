#!/usr/bin/python3
"""Man pages made from what --help says: man_pages.py VERSION -o FOLDER PROGRAM [NAME=SCRIPT...]

A page for the program and one for each of its commands; and one for each script, which a package installs
under NAME. A script that cannot say its help here, for want of what it imports, gets none.
"""

import argparse
import gzip
import re
import sys
from pathlib import Path

from program_help import INDENTED, help_of

STATUS = [("0", "done"), ("1", "something else went wrong"),
          ("2", "input or options are wrong: one line on standard error, FILE:LINE: COLUMN: what is wrong")]


def escaped(text):
    text = text.replace("\\", r"\e").replace("-", r"\-")
    return r"\&" + text if text[:1] in (".", "'") else text


def paragraphs(lines):
    """Lines as typed if they are indented, else filled."""
    kept = False
    for line in lines:
        if bool(INDENTED.match(line)) != kept and line:
            kept = not kept
            yield ".nf" if kept else ".fi"
        yield escaped(line) if line else ".PP"
    if kept:
        yield ".fi"


def entries(items):
    for names, text in items:
        yield ".TP"
        words = re.sub(r",(?=-)", ", ", names).split()
        yield " ".join(rf"\fB{escaped(word)}\fR" if word.startswith("-") else escaped(word) for word in words)
        yield escaped(text)


def page(name, version, summary, said, see):
    lines = [f'.TH "{name.upper()}" 1 "" "armukf {version}" "User Commands"', ".SH NAME",
             f"{escaped(name)} \\- {escaped(summary)}", ".SH SYNOPSIS", escaped(said.usage)]
    if description := list(paragraphs(said.after or said.before)):
        lines += [".SH DESCRIPTION", *description]
    for title, items in said.sections.items():
        if items:
            lines += [f".SH {'COMMANDS' if title == 'subcommands' else title.upper()}", *entries(items)]
    lines += [".SH EXIT STATUS", *entries(STATUS), ".SH SEE ALSO",
              ", ".join(f"\\fB{escaped(other)}\\fR(1)" for other in see if other != name)]
    return "\n".join(lines) + "\n"


def program_pages(program, version, scripts):
    whole = help_of(program)
    commands = dict(whole.sections["subcommands"])
    names = ["armukf", *(f"armukf-{command}" for command in commands), *scripts]
    summary = next(line for line in whole.before if line).rstrip(".")
    yield "armukf", page("armukf", version, summary[0].lower() + summary[1:], whole, names)
    for command, summary in commands.items():
        name = f"armukf-{command}"
        yield name, page(name, version, summary, help_of(program, command), ["armukf", *scripts])


def renamed(line, old, new):
    """The line with that name in place of the other; what stands in a column of its own stays there."""
    longer = len(new) - len(old)
    return re.sub(rf"{re.escape(old)}(.*?\S)( {{{longer + 2},}})(?=\S)",
                  lambda match: new + match[1] + match[2][longer:], line).replace(old, new)


def script_page(name, path, version):
    said = help_of("/usr/bin/python3", path)
    if said is None:
        print(f"manual: no page of {name}: {path} does not run here", file=sys.stderr)
        return None
    said.usage = said.usage.replace(path.name, name)
    _, first, *said.before = [renamed(line, path.name, name) for line in said.before]
    return page(name, version, first.rstrip("."), said, ["armukf"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("version")
    parser.add_argument("program", type=Path)
    parser.add_argument("scripts", nargs="*", metavar="NAME=SCRIPT")
    parser.add_argument("-o", "--output", type=Path, required=True)
    given = parser.parse_args()
    scripts = {name: Path(path) for name, path in (script.split("=", 1) for script in given.scripts)}
    pages = {name: script_page(name, path, given.version) for name, path in scripts.items()}
    pages = {name: text for name, text in pages.items() if text is not None}
    pages |= dict(program_pages(given.program, given.version, list(pages)))
    given.output.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        for script, path in scripts.items():
            text = text.replace(f"scripts/{path.name}", script)
        (given.output / f"{name}.1.gz").write_bytes(gzip.compress(text.encode(), mtime=0))


if __name__ == "__main__":
    main()
