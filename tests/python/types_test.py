#!/usr/bin/python3
"""Types and words of the package: the stub is what the module has, all is typed and explained."""

import ast
import inspect
import shutil
import subprocess
import unittest
from pathlib import Path

from support import ROOT, InFolder

import armukf
from armukf import _core

PACKAGE = Path(armukf.__file__).parent
MYPY = shutil.which("mypy", path="/usr/bin")

# A use that a type checker accepts, but for the last line.
USE = """
import armukf
import numpy as np

record = armukf.simulate(sensor_noise=0.05).samples
session = armukf.Session(armukf.Model().set(k_a=12.0).free("J"), filter="ekf")
found: float = session.run(record)["k_a"][-1]
fit: armukf.Fit = armukf.fit([record, "next.csv"], free_initial="all")
horizon: int | None = armukf.evaluate(record, fit.model)[0].horizon
armukf.Session(armukf.Model()).step("now", 0.0)
"""


def names(owner):
    return {name for name in vars(owner) if not name.startswith("_")}


class Stub(unittest.TestCase):
    def test_it_names_what_the_module_has(self):
        tree = ast.parse((PACKAGE / "_core.pyi").read_text())
        stated = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        variables = {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)}
        self.assertEqual(set(stated) | variables, names(_core))
        for owner in (_core.Model, _core.Session):
            methods = {node.name for node in stated[owner.__name__].body} - {"__init__"}
            self.assertEqual(methods, names(owner))

    def test_statuses_are_the_librarys(self):
        self.assertEqual([status.name.lower() for status in armukf.Status], _core.status_names())

    @unittest.skipUnless(MYPY, "Debian's mypy is not installed")
    def test_a_type_checker_finds_the_package_sound_and_a_wrong_use(self):
        folder = PACKAGE.parent
        done = subprocess.run([MYPY, "--strict", "--cache-dir=/dev/null", "-p", "armukf"], cwd=folder,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        done = subprocess.run([MYPY, "--strict", "--cache-dir=/dev/null", "-c", USE], cwd=folder,
                              capture_output=True, text=True, check=False)
        errors = [line for line in done.stdout.splitlines() if ": error:" in line]
        self.assertEqual(len(errors), 1, done.stdout)
        self.assertRegex(errors[0], r':10: error: Argument 1 to "step" of "Session"')


class Words(InFolder):
    def test_what_is_offered_is_there_and_explained(self):
        self.assertEqual(sorted(set(armukf.__all__)), sorted(armukf.__all__))
        for name in armukf.__all__:
            offered = getattr(armukf, name)
            if inspect.isclass(offered) or inspect.isfunction(offered):
                self.assertTrue(offered is armukf.InputError or inspect.getdoc(offered), name)
        self.assertTrue((PACKAGE / "py.typed").exists())
        self.assertEqual(f"{armukf.InputError.__module__}.{armukf.InputError.__name__}", "armukf.InputError")
        self.assertTrue(issubclass(armukf.InputError, ValueError))

    def test_the_example_of_the_manual_runs(self):
        text = (ROOT / "data/manual/howto/python.md").read_text()
        example = text[text.index("```python\n") + 10:].split("```")[0]
        found = {}
        exec(compile(f"import os; os.chdir({str(self.folder)!r})\n{example}", "python.md", "exec"), found)
        self.assertLess(abs(found["rows"]["k_a"][-1] - 11.7552), 3 * found["rows"].sd_of("k_a")[-1])


if __name__ == "__main__":
    unittest.main()
