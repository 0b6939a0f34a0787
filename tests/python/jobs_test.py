#!/usr/bin/python3
"""Jobs on whole records: the numbers of the program's commands, to the last digit."""

import json
import signal
import sys
import time
import unittest
from dataclasses import fields
from unittest import mock

import numpy as np
from support import RECORD, InFolder, columns, program, program_json, untimed

import armukf


class AsTheProgram(InFolder):
    def setUp(self):
        super().setUp()
        self.samples = armukf.read_record(RECORD)

    def test_records_from_files(self):
        wanted = columns("\n".join(line for line in RECORD.read_text().splitlines() if line[0] != "#"))
        self.assert_same(self.samples, np.column_stack([wanted[name] for name in "tuy"]))
        path = self.folder / "other.csv"
        path.write_text("time;torque;speed\n0;1;2\n0.001;3;\n")
        self.assert_same(armukf.read_record(path, t="time", u="torque", y="speed"),
                         [[0, 1, 2], [0.001, 3, np.nan]])

    def test_simulate(self):
        path = self.folder / "run.csv"
        program("simulate", "-o", path, "--experiment", "validation1", "--seed", 3, "--samples", 3000,
                "--sensor-noise", 0.1, "--sensor-pole", 0.5, "--torque-disturbance", 0.2, "--torque-pole", 0.9,
                "--effect", "backlash", "--states", "--quiet")
        model = armukf.Model.published_estimate().add_effect("backlash")
        found = armukf.simulate(model, "validation1", seed=3, samples=3000, sensor_noise=0.1,
                                sensor_pole=0.5, torque_disturbance=0.2, torque_pole=0.9)
        text = "\n".join(line for line in path.read_text().splitlines() if line[0] != "#")
        wanted = columns(text)
        self.assertEqual(list(found.to_pandas()), list(wanted))
        for name, column in wanted.items():
            self.assert_same(found.to_pandas()[name], column, name)

    def test_estimate(self):
        wanted = program_json("estimate", RECORD, "--filter", "ekf", "--passes", 2)
        del wanted["input"]  # what became of the file's rows
        for record in (RECORD, str(RECORD), self.samples):
            found = armukf.estimate(record, filter="ekf", passes=2)
            self.assertEqual(untimed(found.json), wanted)
        self.assertEqual(found.parameters["k_a"].sd_model, wanted["parameters"]["k_a"]["sd_model"])
        self.assertEqual(found.model["k_a"], wanted["parameters"]["k_a"]["value"])
        self.assert_same(found.covariance, wanted["covariance"]["matrix"])

    def test_score(self):
        wanted = json.loads(program("estimate", RECORD, "--score"))
        self.assertEqual(untimed(armukf.score(RECORD)), untimed(wanted))

    def test_smooth(self):
        found = armukf.smooth(RECORD)
        wanted = columns(program("smooth", RECORD, "--quiet"))
        self.assertEqual(list(found.to_pandas()), list(wanted))
        for name, column in wanted.items():
            self.assert_same(found.to_pandas()[name], column, name)
        self.assertEqual(untimed(found.json), program_json("smooth", RECORD))

    def test_fit(self):
        path = self.folder / "found.toml"
        wanted = program_json("fit", RECORD, "--free-initial", "all", "--save", path)
        found = armukf.fit(RECORD, free_initial="all")
        self.assertEqual(untimed(found.json), wanted)
        self.assertEqual(found.model, armukf.Model(path))
        self.assertEqual(found.parameters["k_a"].sd_hac, wanted["parameters"]["k_a"]["sd_hac"])
        self.assertEqual(found.experiments[0].initial_state["speed_arm"].value,
                         wanted["experiments"][0]["initial_state"]["speed_arm"]["value"])

    def test_fit_of_several_records_with_options(self):
        path = self.folder / "second.csv"
        program("simulate", "-o", path, "--samples", 1500, "--seed", 4, "--sensor-noise", 0.1, "--quiet")
        words = ("--free-initial", "speed_motor,twist_arm", "--initial", "twist_arm=0.1", "--robust",
                 "--starts", 2, "--iterations", 7)
        options = dict(free_initial=["speed_motor", "twist_arm"], initial={"twist_arm": 0.1}, robust=True,
                       starts=2, iterations=7)
        self.assertEqual(untimed(armukf.fit([RECORD, path], **options).json),
                         program_json("fit", RECORD, path, *words))
        self.assertEqual(untimed(armukf.fit(RECORD, criterion="prediction", iterations=3).json),
                         program_json("fit", RECORD, "--criterion", "prediction", "--iterations", 3))

    def test_evaluate(self):
        model = armukf.Model().set(k_a=12)
        for options, words in (({}, ()), ({"horizon": 20}, ("--horizon", 20)),
                               ({"initial_from": 0.1}, ("--initial-from", 0.1))):
            found, = armukf.evaluate(RECORD, model, **options)
            path = self.folder / "rows.csv"
            wanted, = program_json("evaluate", RECORD, "--set", "k_a=12", "--rows", path, *words)["experiments"]
            self.assertEqual(found.json, wanted)
            rows = columns(path.read_text())
            self.assertEqual(list(found.to_pandas()), list(rows))
            self.assert_same(found.y_hat, rows["y_hat"])
            self.assert_same(found.residual, rows["residual"])

    def test_pieces_between_gaps_are_evaluations_of_their_own(self):
        self.samples[1000:, 0] += 1.0
        found = armukf.evaluate(self.samples)
        self.assertEqual([len(e.y_hat) for e in found], [1000, 1000])
        self.assertEqual(found[1].experiment.from_s, self.samples[1000, 0])

    def test_compare(self):
        found = armukf.compare(RECORD, free_initial="all")
        wanted = program_json("compare", RECORD, "--free-initial", "all")
        self.assertEqual(untimed(found.json), wanted)
        self.assertEqual(found.parameters["a_m"].batch, found.batch.parameters["a_m"].value)
        self.assertEqual(found.recursive.model["a_m"], found.parameters["a_m"].recursive)
        self.assertEqual(list(found.to_pandas().index), list(found.parameters))

    def test_start_values(self):
        record = armukf.simulate(samples=8000, sensor_noise=0.05).samples
        path = self.folder / "run.csv"
        program("simulate", "-o", path, "--samples", 8000, "--sensor-noise", 0.05, "--quiet")
        found = armukf.estimate(record, armukf.start_from_frequency_response(record))
        wanted = program_json("estimate", path, "--start", "frequency")
        del wanted["input"]
        self.assertEqual(untimed(found.json), wanted)


class Diagnose(InFolder):
    def test_is_what_the_program_finds(self):
        path = self.folder / "bias.csv"
        program("simulate", "-o", path, "--samples", 6000, "--sensor-noise", 0.1, "--effect", "torque_bias",
                "--set", "torque_bias=0.5", "--quiet")
        told = []
        found = armukf.diagnose(path, progress=lambda stage, share: told.append((stage, share)))
        saved = self.folder / "found.toml"
        wanted = program_json("diagnose", path, "--save", saved)
        self.assertEqual(untimed(found.json), wanted)
        self.assertEqual(found.model, armukf.Model(saved))
        self.assertEqual(found.verdict, wanted["verdict"])
        self.assertEqual([e.name for e in found.effects], [e["name"] for e in wanted["effects"]])
        self.assertEqual(found.after.validation.mse, wanted["after"]["validation"]["mse"])
        self.assertEqual(len(found.residual_after), len(found.samples))
        self.assertTrue(told and all(0 <= share <= 1 for _, share in told))
        self.assertRegex(found._repr_html_(), "^<table>.*</table>$")
        self.assertEqual(len(found.to_pandas()), len(found.candidates))

    def test_who_is_told_can_end_it(self):
        def stop(*_):
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            armukf.diagnose(armukf.simulate(samples=6000, sensor_noise=0.1).samples, progress=stop)


class Refusals(InFolder):
    def test_options(self):
        samples = armukf.read_record(RECORD)
        whole = "must be a whole number from 1 to 2147483647, not"
        for message, job in (
                (f"passes: {whole} '0'", lambda: armukf.estimate(samples, passes=0)),
                ("threads: must be a whole number from 0 to 2147483647, not '-1'",
                 lambda: armukf.fit(samples, threads=-1)),
                (f"starts: {whole} 'nan'", lambda: armukf.fit(samples, starts=float("nan"))),
                ("seed: must be a whole number from 0 to 18446744073709551615, not '-1'",
                 lambda: armukf.fit(samples, seed=-1)),
                ("criterion: must be simulation or prediction, not guess",
                 lambda: armukf.fit(samples, criterion="guess")),
                ("unknown state 'speed'; known are: twist_gear, twist_arm, speed_motor, speed_gear, speed_arm",
                 lambda: armukf.fit(samples, free_initial="speed")),
                ("initial: must be finite, not {'twist_arm': nan}",
                 lambda: armukf.fit(samples, initial={"twist_arm": float("nan")})),
                (f"horizon: {whole} '0'", lambda: armukf.evaluate(samples, horizon=0)),
                ("initial_from: must be above 0 and at most 1, not 2",
                 lambda: armukf.evaluate(samples, initial_from=2)),
                ("unknown experiment 'fun'; known are: estimation, validation1, validation2, validation3",
                 lambda: armukf.simulate(experiment="fun")),
                ("sensor_noise: must be at least 0 and finite, not -0.1", lambda: armukf.simulate(sensor_noise=-0.1)),
                ("samples: must be a whole number from 1 to 5000000, not '0'", lambda: armukf.simulate(samples=0)),
                ("sample_time_s: must be above 0 and at most 0.002, not 0.01",
                 lambda: armukf.simulate(sample_time_s=0.01)),
                (f"most_effects: {whole} '0'", lambda: armukf.diagnose(samples, most_effects=0))):
            self.refused(message, job)

    def test_records(self):
        samples = armukf.read_record(RECORD)
        nan = samples.copy()
        nan[7, 1] = np.nan
        self.refused("record[7]: u: nan is not a finite number", armukf.estimate, nan)
        self.refused("records[1][7]: u: nan is not a finite number", armukf.fit, [samples, nan])
        self.refused("validate[0]: must hold float64, not float32; see numpy.ndarray.astype", armukf.diagnose,
                     samples, [samples.astype(np.float32)])
        self.refused("record: has no samples", armukf.smooth, samples[:0])
        self.refused("records: must be a NumPy array, not NoneType", armukf.evaluate, None)
        path = self.folder / "bad.csv"
        path.write_text("t,u,y\n0,1,2\n1,x,3\n")
        self.refused(f"{path}:3: u: 'x' is not a number", armukf.fit, path)
        with self.assertRaises(ValueError):
            armukf.fit(samples[:3])


class Interrupts(InFolder):
    def test_they_end_a_fit_long_before_its_end(self):
        def interrupt(*_):
            raise KeyboardInterrupt
        before = signal.signal(signal.SIGALRM, interrupt)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        samples = armukf.simulate(sensor_noise=0.1).samples
        for criterion in ("simulation", "prediction"):
            begin = time.monotonic()
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            with self.assertRaises(KeyboardInterrupt):
                armukf.fit(samples, criterion=criterion, starts=1000)  # minutes
            self.assertLess(time.monotonic() - begin, 60.0)


class Results(InFolder):
    def test_all_show_themselves_and_their_names_are_safe(self):
        samples = armukf.read_record(RECORD)
        path = self.folder / "<b>.csv"
        path.write_bytes(RECORD.read_bytes())
        results = (armukf.simulate(samples=3000), armukf.estimate(samples), armukf.smooth(samples),
                   armukf.fit(samples), armukf.evaluate(path)[0], armukf.compare(samples))
        for result in results:
            self.assertRegex(result._repr_html_(), "^<table>.*</table>$")
            self.assertNotIn("<b>", result._repr_html_())
            self.assertGreater(len(result.to_pandas()), 0)
            with self.assertRaises(AttributeError):
                setattr(result, fields(result)[0].name, None)

    def test_numbers_that_json_cannot_say_are_nan(self):
        innovation = armukf.results.read(armukf.Innovation, {"fit_percent": None, "rmse": 1, "mean_nis": 2.0,
                                                             "ljung_box_p": 0.5, "log_likelihood": None, "new": 1})
        self.assertTrue(np.isnan(innovation.fit_percent) and np.isnan(innovation.log_likelihood))
        self.assertEqual((innovation.rmse, innovation.model_lacks), (1.0, None))

    def test_a_smoother_claims_no_test_that_it_has_not_made(self):
        samples = armukf.read_record(RECORD)
        self.assertIsNotNone(armukf.estimate(samples).innovation.model_lacks)
        smoothed = armukf.smooth(samples, passes=1).innovation
        self.assertEqual((smoothed.model_lacks, smoothed.not_noise_percent), (None, None))

    def test_without_pandas_it_is_said(self):
        with mock.patch.dict(sys.modules, {"pandas": None}):
            with self.assertRaisesRegex(ModuleNotFoundError, r"to_pandas\(\) needs pandas"):
                armukf.estimate(RECORD).to_pandas()


if __name__ == "__main__":
    unittest.main()
