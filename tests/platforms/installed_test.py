#!/usr/bin/python3
"""The installed tree, as it reaches other machines and other programs: installed_test.py PREFIX COMPILER

Moved elsewhere it still runs, by the best build that this processor can run. Whoever builds against it
gets no flags for a processor, and types whose layout does not depend on his own.
"""

import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import same_numbers

CONSUMER = Path(__file__).resolve().parents[1] / "consumer" / "consumer.cpp"
BASELINE = "x86-64-v2"
TYPES = ["Columns", "CsvReader", "Diagnosis", "Estimate", "EstimatorSettings", "EvaluateSettings",
         "Evaluation", "ExperimentSettings", "Identification", "IdentifySettings", "Model", "ModelFile",
         "Parameter", "Record", "RecursiveEstimate", "Sample", "Session", "SmoothedRecord",
         "TraceSettings"]
PREFIX, COMPILER = Path(), ""


def output(*words, **options):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False,
                          **options)
    if done.returncode:
        raise AssertionError(f"{words}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def compiled(source, *flags):
    return output(COMPILER, "-std=c++20", "-I", PREFIX / "include", *flags, "-x", "c++", "-",
                  input=source)


class Program(unittest.TestCase):
    def test_moved_tree_runs_the_best_build_for_this_processor(self):
        folders = [f.name for f in (PREFIX / "lib").glob("**/glibc-hwcaps/*")]
        best = max(filter(same_numbers.runs_here, folders), default=BASELINE)
        with tempfile.TemporaryDirectory() as folder:
            moved = shutil.copytree(PREFIX, Path(folder) / "elsewhere", symlinks=True)
            program = moved / "bin" / "armukf"
            self.assertIn(f"(built for {best})", output(program, "--version"))
            for processor in filter(same_numbers.runs_here, [BASELINE, *folders]):
                self.assertIn(f"(built for {processor})",
                              output(*same_numbers.under(processor, program), "--version"))
            rows = output(program, "estimate", same_numbers.RECORD, "--quiet").splitlines()
            self.assertEqual(len(rows), 2001)


class Package(unittest.TestCase):
    def test_hands_on_no_flags(self):
        files = list(PREFIX.glob("**/cmake/armukf/armukfTargets*.cmake"))
        self.assertGreaterEqual(len(files), 2)
        for file in files:
            self.assertNotRegex(file.read_text(), r"-march|-m[a-z]|COMPILE_OPTIONS|COMPILE_DEFINITIONS")

    def test_public_header_needs_the_standard_library_alone(self):
        reached = compiled(CONSUMER.read_text(), "-M").replace("\\\n", " ").split()
        foreign = [f for f in reached if re.search(r"/(eigen3|boost|fmt|ceres|nlohmann|toml)", f, re.I)]
        self.assertEqual(foreign, [])

    def test_layout_of_types_is_the_same_for_every_processor(self):
        sizes = ", ".join(f"sizeof(armukf::{t}), alignof(armukf::{t})" for t in TYPES)
        source = f'#include "armukf/armukf.hpp"\nextern const unsigned long sizes[] = {{{sizes}}};\n'
        tables = [re.search(r"^sizes:\n((?:\s+\.quad\s+\d+\n)+)",
                            compiled(source, "-S", "-o", "-", f"-march=x86-64-v{version}"), re.M)
                  for version in (2, 4)]
        self.assertEqual(len(tables[0][1].split()), 4 * len(TYPES))
        self.assertEqual(tables[0][1], tables[1][1])


if __name__ == "__main__":
    COMPILER = sys.argv.pop()
    PREFIX = Path(sys.argv.pop())
    unittest.main()
