#!/usr/bin/python3
"""Completion of the shells, by what the program itself says: completion_test.py PROGRAM FOLDER

FOLDER: completion.bash and completion.zsh.
"""

import os
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM, FOLDER = Path(sys.argv.pop(1)).resolve(), Path(sys.argv.pop(1)).resolve()
COMMANDS = ["estimate", "smooth", "simulate", "fit", "evaluate", "compare", "diagnose", "export"]

BASH = f"""
source {FOLDER}/completion.bash
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
_armukf "$1" "${{COMP_WORDS[COMP_CWORD]}}" "${{COMP_WORDS[COMP_CWORD - 1]}}"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def help_of(*words):
    return subprocess.run([PROGRAM, *words, "--help"], capture_output=True, text=True, check=True).stdout


def options_of(command):
    listed = re.findall(r"^  (-[^ =:{]*)", help_of(command), re.M)
    return [option for names in listed for option in names.split(",")]


class Bash(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "run.csv").touch()

    def completed(self, *words):
        done = subprocess.run(["bash", "-c", BASH, "bash", str(PROGRAM), *words], cwd=self.folder,
                              capture_output=True, text=True, check=True)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_commands_and_files(self):
        self.assertEqual(self.completed(""), [*COMMANDS, "run.csv"])
        self.assertEqual(self.completed("sm"), ["smooth"])
        self.assertEqual(self.completed("fit", "r"), ["run.csv"])

    def test_every_option_of_every_command(self):
        for command in COMMANDS:
            options = options_of(command)
            self.assertGreater(len(options), 8)
            self.assertEqual(self.completed(command, "-"), options, command)
        self.assertEqual(self.completed("run.csv", "--chec"), ["--checkpoint"])  # of the default command

    def test_what_an_option_may_be(self):
        self.assertEqual(self.completed("estimate", "--on-error", ""), ["stop", "skip", "missing"])
        self.assertEqual(self.completed("fit", "--criterion", "pre"), ["prediction"])
        self.assertEqual(self.completed("simulate", "--experiment", "v"),
                         ["validation1", "validation2", "validation3"])
        self.assertIn("srukf", self.completed("run.csv", "--filter", ""))
        self.assertEqual(self.completed("estimate", "--save", ""), ["run.csv"])


@unittest.skipUnless(shutil.which("zsh"), "no zsh")
class Zsh(unittest.TestCase):
    """As a terminal sees it: words, and Tab."""

    def typed(self, text, expected):
        """What zsh shows, up to the word that is expected."""
        setup = (f"cd /; PS1=; autoload -U compinit; compinit -u -D; fpath=({FOLDER} $fpath); "
                 f"autoload -Uz completion.zsh; compdef completion.zsh armukf; path=({PROGRAM.parent} $path); "
                 "echo rea''dy\n")
        child, terminal = pty.fork()
        if child == 0:
            os.environ["TERM"] = "dumb"
            os.execlp("zsh", "zsh", "-f", "-i")
        try:
            os.write(terminal, setup.encode())
            self.read_until(terminal, "ready")
            os.write(terminal, text.encode())
            return self.read_until(terminal, expected)
        finally:
            os.close(terminal)
            os.waitpid(child, 0)

    def read_until(self, terminal, expected):
        seen, end = "", time.monotonic() + 20
        while expected not in seen and time.monotonic() < end:
            if select.select([terminal], [], [], 0.2)[0]:
                seen += re.sub(r"[\x00-\x09\x0b-\x1f]", "", os.read(terminal, 4096).decode(errors="replace"))
        self.assertIn(expected, seen)
        return seen

    def test_a_command(self):
        self.typed("armukf simu\t", "armukf simulate")

    def test_an_option(self):
        self.typed("armukf simulate --torque-d\t", "armukf simulate --torque-disturbance")


if __name__ == "__main__":
    unittest.main()
