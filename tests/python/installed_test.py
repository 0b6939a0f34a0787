#!/usr/bin/python3
"""The installed package, as other machines have it: installed_test.py PROGRAM PREFIX FOLDER

Moved elsewhere it still finds its library, and so it does in a virtual environment. FOLDER: of packages,
from the prefix.
"""

import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

from support import RECORD, ROOT, InFolder

PREFIX, FOLDER = Path(sys.argv.pop(1)), sys.argv.pop(1)

USE = f"""
import armukf
assert armukf.Session().run(armukf.read_record({str(RECORD)!r})).status.max() == 0
print(armukf.__file__, armukf.processor)
"""


def run(python, *words, **environment):
    done = subprocess.run([str(python), *map(str, words)], capture_output=True, text=True, check=False,
                          env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | environment)
    if done.returncode:
        raise AssertionError(f"{words}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout.strip()


class Installed(InFolder):
    def test_moved_tree_runs(self):
        moved = shutil.copytree(PREFIX, self.folder / "elsewhere", symlinks=True)
        said = run(sys.executable, "-c", USE, PYTHONPATH=str(moved / FOLDER))
        self.assertTrue(said.startswith(str(moved)), said)
        self.assertIn(f"built for {said.split()[-1]})", run(moved / "bin/armukf", "--version"))  # the same library

    def test_a_virtual_environment_is_a_prefix(self):
        home = self.folder / "venv"
        run(sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", home)
        shutil.copytree(PREFIX, home, symlinks=True, dirs_exist_ok=True)
        folder = run(home / "bin/python", ROOT / "lib/python/site_folder.py", home)
        shutil.move(home / FOLDER / "armukf", home / folder / "armukf")
        self.assertTrue(run(home / "bin/python", "-c", USE).startswith(str(home)))

    def test_debian_has_its_folders(self):
        def folder(prefix):
            return run("/usr/bin/python3", ROOT / "lib/python/site_folder.py", prefix)
        self.assertEqual(folder("/usr"), "lib/python3/dist-packages")
        self.assertRegex(folder("/usr/local"), r"^lib/python3\.\d+/dist-packages$")


if __name__ == "__main__":
    unittest.main()
