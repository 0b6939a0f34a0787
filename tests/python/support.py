"""What the tests of the Python package share. Each is started as TEST.py PROGRAM, the package in PYTHONPATH."""

import csv
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RECORD = ROOT / "data/short_record.csv"  # a second of the published estimate's arm
PROGRAM = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else None


def program(*words):
    done = subprocess.run([str(word) for word in (PROGRAM, *words)], capture_output=True, text=True,
                          check=False)
    if done.returncode:
        raise AssertionError(f"{words}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def program_json(*words):
    """Without the times that it took."""
    return untimed(json.loads(program(*words, "--json", "-", "--quiet")))


def untimed(content):
    if isinstance(content, dict):
        return {k: untimed(v) for k, v in content.items() if k not in ("seconds", "samples_per_second")}
    return [untimed(v) for v in content] if isinstance(content, list) else content


def columns(text):
    """A CSV by its header's names: numbers, or words where they are none."""
    head, *rows = csv.reader(text.splitlines())
    table = {}
    for name, cells in zip(head, zip(*rows)):
        table[name] = list(cells) if name == "status" else np.array([float(c or "nan") for c in cells])
    return table


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def assert_same(self, found, wanted, what=""):
        """To the last bit; NaN is NaN."""
        np.testing.assert_array_equal(np.asarray(found), np.asarray(wanted), err_msg=str(what))

    def refused(self, message, job, *words, **options):
        import armukf
        with self.assertRaises(armukf.InputError) as caught:
            job(*words, **options)
        self.assertEqual(str(caught.exception), message)
