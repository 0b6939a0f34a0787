#!/usr/bin/python3
"""Checks that each source includes only from the layers below its own, and that nothing strange
lies at the top of the tree. Prints `FILE:LINE: what is wrong`; exit status 1 if there is any.

    check_layers.py               checks this tree
    check_layers.py --self-check  checks that this script finds what it should
"""

import posixpath
import re
import sys
import tempfile
from pathlib import Path

# What each layer may include besides itself. The four above core know nothing of each other, nor do
# the two jobs above these; a diagnosis is a job that is made of batch fits. Streams stand aside:
# only what reads and writes files knows them, reports and the program. Above all others stands
# armukf.hpp, what a user of the library includes; the Python package stands where the program does.
CORE = {"core"}
TOOLS = CORE | {"model", "filter", "ode", "fit"}
JOBS = TOOLS | {"online", "batch", "diagnosis"}
LIBRARY = JOBS | {"io", "report", "armukf.hpp"}
BELOW = {
    "core": set(),
    "io": CORE,
    "model": CORE, "filter": CORE, "ode": CORE, "fit": CORE,
    "online": TOOLS, "batch": TOOLS, "diagnosis": TOOLS | {"batch"},
    "report": JOBS | {"io"},
    "armukf.hpp": JOBS | {"io", "report"},
    "python": LIBRARY,
    "apps": LIBRARY,
    "tests": LIBRARY,
}

TOP = {"lib", "apps", "data", "scripts", "tests",
       "README.md", "LICENSE", "CMakeLists.txt", "CMakePresets.json"}

INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    """Layer of a file, by its path from the top of the tree; None if it is in none."""
    parts = path.split("/")
    if parts[:2] == ["lib", "armukf"]:
        return parts[2] if len(parts) > 2 and parts[2] in LIBRARY else None
    if parts[:2] == ["lib", "python"]:
        return "python"
    return parts[0] if parts[0] in BELOW else None


def included_layer(root, path, quote, target):
    """Layer that an include line reaches; None if it leaves the tree."""
    beside = posixpath.normpath(posixpath.join(posixpath.dirname(path), target))
    if quote == '"' and (root / beside).is_file():
        return layer_of(beside)
    if target.startswith("armukf/"):
        return target.split("/")[1]
    for folder in ("apps", "tests"):
        if quote == '"' and (root / folder / target).is_file():
            return folder
    return None


def include_faults(root):
    for folder in ("lib", "apps", "tests"):
        for file in sorted((root / folder).rglob("*.[ch]pp")):
            path = file.relative_to(root).as_posix()
            layer = layer_of(path)
            if layer is None:
                yield f"{path}:1: lies in no known layer"
                continue
            for number, line in enumerate(file.read_text().splitlines(), 1):
                if not (match := INCLUDE.match(line)):
                    continue
                other = included_layer(root, path, *match.groups())
                if other not in BELOW[layer] | {layer, None}:
                    yield f"{path}:{number}: {layer} must not include {match[2]} of {other}"


def top_faults(root):
    ignored = set()
    if (root / ".gitignore").is_file():
        ignored = {line.strip("/") for line in (root / ".gitignore").read_text().split()}
    for entry in sorted(root.iterdir()):
        if entry.name not in TOP | ignored and not entry.name.startswith("."):
            yield f"{entry.name}:1: has no place at the top of the tree"


def faults(root):
    return [*top_faults(root), *include_faults(root)]


# A file, an include line in it, and whether that is a fault.
CASES = [
    ("lib/armukf/core/a.hpp", '#include "armukf/core/b.hpp"', False),
    ("lib/armukf/core/a.hpp", '#include <vector>', False),
    ("lib/armukf/core/a.hpp", '#include "armukf/model/b.hpp"', True),
    ("lib/armukf/core/a.hpp", '  #  include <armukf/io/b.hpp>', True),
    ("lib/armukf/model/effects/a.hpp", '#include "armukf/core/b.hpp"', False),
    ("lib/armukf/model/effects/a.hpp", '#include "armukf/model/b.hpp"', False),
    ("lib/armukf/model/effects/a.hpp", '#include "armukf/ode/b.hpp"', True),
    ("lib/armukf/filter/a.cpp", '#include "armukf/model/b.hpp"', True),
    ("lib/armukf/filter/a.cpp", '// #include "armukf/model/b.hpp"', False),
    ("lib/armukf/ode/a.cpp", '#include "armukf/fit/b.hpp"', True),
    ("lib/armukf/fit/a.cpp", '#include "armukf/batch/b.hpp"', True),
    ("lib/armukf/fit/a.cpp", '#include "../batch/there.hpp"', True),
    ("lib/armukf/online/a.cpp", '#include "armukf/filter/b.hpp"', False),
    ("lib/armukf/online/a.cpp", '#include "armukf/batch/b.hpp"', True),
    ("lib/armukf/diagnosis/a.cpp", '#include "armukf/online/b.hpp"', True),
    ("lib/armukf/diagnosis/a.cpp", '#include "armukf/batch/b.hpp"', False),
    ("lib/armukf/batch/a.cpp", '#include "armukf/diagnosis/b.hpp"', True),
    ("lib/armukf/batch/a.cpp", '#include "armukf/io/b.hpp"', True),
    ("lib/armukf/io/a.cpp", '#include "armukf/core/b.hpp"', False),
    ("lib/armukf/io/a.cpp", '#include "armukf/model/b.hpp"', True),
    ("lib/armukf/batch/a.cpp", '#include "armukf/report/b.hpp"', True),
    ("lib/armukf/report/a.cpp", '#include "armukf/diagnosis/b.hpp"', False),
    ("lib/armukf/report/a.cpp", '#include "armukf/io/b.hpp"', False),
    ("lib/armukf/armukf.hpp", '#include "armukf/report/b.hpp"', False),
    ("lib/armukf/model/a.cpp", '#include "armukf/armukf.hpp"', True),
    ("lib/armukf/io/a.cpp", '#include "there.hpp"', True),  # in apps/
    ("lib/armukf/misc/a.cpp", '', True),
    ("lib/armukf/a.hpp", '', True),
    ("lib/python/a.cpp", '#include "armukf/report/b.hpp"', False),
    ("lib/python/a.cpp", '#include "there.hpp"', True),  # in apps/
    ("lib/armukf/report/a.cpp", '#include "../../python/there.hpp"', True),
    ("apps/a.cpp", '#include "armukf/io/b.hpp"', False),
    ("apps/a.cpp", '#include "armukf/misc/b.hpp"', True),
    ("tests/io/a_test.cpp", '#include "armukf/io/b.hpp"', False),
    ("tests/io/a_test.cpp", '#include "there.hpp"', True),  # in apps/
    ("apps/main.cpp", '#include "there.hpp"', False),
    ("a.cpp", '', True),
    ("README.md", '', False),
    (".clang-format", '', False),
    ("build/a.txt", '', False),
]


def self_check():
    wrong = 0
    for path, line, is_fault in CASES:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            written = {".gitignore": "/build/", "apps/there.hpp": "", path: f"\n{line}\n"}
            if "../batch" in line:
                written["lib/armukf/batch/there.hpp"] = ""
            if "/python/" in line:
                written["lib/python/there.hpp"] = ""
            for name, text in written.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            found = faults(root)
        place = f"{path}:2:" if line else f"{path}:1:"
        if [fault.startswith(place) for fault in found] != [True] * is_fault:
            wrong += 1
            print(f"{path}: {line or 'its place'}: expected {is_fault}, found {found}")
    return wrong


def main(arguments):
    if arguments == ["--self-check"]:
        return 1 if self_check() else 0
    if arguments:
        print(__doc__, file=sys.stderr)
        return 2
    found = faults(Path(__file__).resolve().parent.parent)
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
