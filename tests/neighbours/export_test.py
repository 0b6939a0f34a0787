#!/usr/bin/python3
"""What `armukf export` writes, compiled and run, beside what armukf simulates: export_test.py PROGRAM

`simulate` goes by equations in C++ and an adaptive stepper; here runs what was exported, by Runge-Kutta steps of
its own that are short enough for its error to be far below what is allowed.
"""

import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = Path(sys.argv.pop(1)).resolve()
ALLOWED = 1e-6  # rad/s
STRICT = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-O2"]
# Where the usual value shows little within half a second, bends more sharply than both steps follow, or runs away.
TELLING = {"payload_time": 0.2, "payload_until": 0.4, "torque_slew": 3000.0, "thermal_friction_time": 0.3,
           "drive_response_time": 0.002, "thermal_torque_heated_torque": 30.0}
GROUPS = 6  # of effects, so that no model has more states than armukf allows

DRIVER = """
#include <stdio.h>
#include "arm.h"

/* Columns t and u, then on each line the motor's speed; the first line holds the states instead. */
int main(void) {
  double x[ARM_STATES], t, u, next_t, next_u;
  for (int i = 0; i < ARM_STATES; ++i)
    if (scanf("%lf", &x[i]) != 1) return 1;
  if (scanf("%lf %lf", &t, &u) != 2) return 1;
  for (;;) {
    printf("%.17g\\n", arm_measured(t, u, x, arm_values));
    if (scanf("%lf %lf", &next_t, &next_u) != 2) return 0;
    const double dt = (next_t - t) / 100.0;
    for (int n = 0; n < 100; ++n) arm_step(t + n * dt, dt, u, arm_values, x);
    t = next_t;
    u = next_u;
  }
}
"""

OCTAVE = """
arm_parameters
values = num2cell([parameters.Value]);
f = @(t, x, u) arm(t, x, u, values{:}, {});
record = dlmread('inputs');
x = dlmread('states')';
for k = 1:rows(record)
  t = record(k, 1); u = record(k, 2);
  [~, y] = f(t, x, u);
  printf('%.17g\\n', y);
  if k == rows(record), break, end
  h = (record(k + 1, 1) - t) / 20;
  for n = 1:20
    k1 = f(t, x, u);
    k2 = f(t + h / 2, x + h / 2 * k1, u);
    k3 = f(t + h / 2, x + h / 2 * k2, u);
    k4 = f(t + h, x + h * k3, u);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    t += h;
  end
end
"""


def run(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **options)


def effects():
    """All that there are."""
    said = run(PROGRAM, "export", "--to", "c", "-o", ".", "--effect", "?").stderr
    return re.findall(r"\w+", said.split("known are:")[1])


class Exported(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def done(self, *words, **options):
        done = run(*words, cwd=self.folder, **options)
        self.assertEqual((done.returncode, done.stderr), (0, ""), words)
        return done.stdout

    def sizes(self, chosen):
        """Values for these effects' parameters, so that each of them does something."""
        words = [word for effect in chosen for word in ("--effect", effect)]
        self.done(PROGRAM, "export", "--to", "matlab", "-o", ".", *words)
        rows = re.findall(r"'Name', '(\w+)'.*'Value', (\S+), 'Minimum', \S+, 'Maximum', (\S+),",
                          (self.folder / "arm_parameters.m").read_text().split("initial_states = ")[0])
        for name, value, most in rows[13:]:  # the arm's own come first
            if name in TELLING or float(value) == 0.0:
                words += ["--set", f"{name}={TELLING.get(name, 0.1 * min(1.0, float(most)))}"]
        return words

    def simulated(self, chosen, samples):
        """Records an arm with these effects; its first states, its inputs, and what it measured."""
        self.done(PROGRAM, "simulate", "-o", "run.csv", "--save", "model.toml", "--states", "--quiet",
                  "--samples", samples, *self.sizes(chosen))
        lines = [line for line in (self.folder / "run.csv").read_text().splitlines() if not line.startswith("#")]
        rows = list(csv.reader(lines))[1:]
        return " ".join(rows[0][3:]), "\n".join(f"{t} {u}" for t, u, *_ in rows), [float(row[2]) for row in rows]

    def assert_near(self, said, measured, what):
        found = [float(line) for line in said.split()]
        self.assertEqual(len(found), len(measured))
        self.assertLess(max(abs(a - b) for a, b in zip(found, measured)), ALLOWED, what)
        self.assertGreater(max(map(abs, measured)), 1.0)  # it moved

    def test_c_function_says_what_simulate_says_with_every_effect(self):
        known = effects()
        self.assertGreaterEqual(len(known), 27)
        (self.folder / "driver.c").write_text(DRIVER)
        for first in range(GROUPS):
            chosen = known[first::GROUPS]
            states, inputs, measured = self.simulated(chosen, 1000)
            self.done(PROGRAM, "export", "--to", "c", "-o", ".", "--model", "model.toml")
            self.done("gcc", "-std=c99", *STRICT, "driver.c", "arm.c", "-lm", "-o", "driver")
            self.assert_near(self.done("./driver", input=f"{states}\n{inputs}\n"), measured, chosen)

    def test_header_serves_cplusplus(self):
        self.done(PROGRAM, "export", "--to", "c", "-o", "made/by/it", "--name", "Left_arm2")
        use = '#include "made/by/it/Left_arm2.h"\nint main() { return LEFT_ARM2_STATES - 5; }\n'
        self.done("g++", *STRICT, "-x", "c++", "-", "-o", "use", input=use)
        self.done("./use")

    @unittest.skipUnless(shutil.which("octave-cli"), "no octave")
    def test_matlab_function_says_what_simulate_says(self):
        chosen = ["backlash", "gravity", "presliding_friction", "friction_curve", "thermal_friction", "sensor_lag"]
        states, inputs, measured = self.simulated(chosen, 400)
        self.done(PROGRAM, "export", "--to", "matlab", "-o", ".", "--model", "model.toml")
        (self.folder / "states").write_text(states)
        (self.folder / "inputs").write_text(inputs)
        (self.folder / "go.m").write_text(OCTAVE)
        said = self.done("octave-cli", "--no-init-file", "--no-history", "go.m", env={**os.environ, "LC_ALL": "C"})
        self.assert_near(said, measured, chosen)

    def test_what_cannot_be_is_refused_in_one_line(self):
        for words, complaint in ((["--to", "pascal"], "--to: unknown language 'pascal', it is one of c, matlab"),
                                 (["--to", "c", "--name", "2nd"], "--name: '2nd' cannot be a name there: a letter, "
                                  "then letters, digits and _, 50 at most"),
                                 (["--to", "matlab", "--name", "end"], "--name: 'end' cannot be a name there: a "
                                  "letter, then letters, digits and _, 50 at most"),
                                 (["--to", "c", "--effect", "magic"], None)):
            done = run(PROGRAM, "export", "-o", ".", *words, cwd=self.folder)
            self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1), done.stderr)
            if complaint is not None:
                self.assertEqual(done.stderr.strip(), complaint)
        self.assertEqual(list(self.folder.iterdir()), [])


if __name__ == "__main__":
    unittest.main()
