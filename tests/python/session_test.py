#!/usr/bin/python3
"""Sessions: the same numbers as the program, arrays without copies, threads, refusals."""

import gc
import json
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np
from support import RECORD, InFolder, columns, program

import armukf


def with_faults(samples):
    """Missing and impossible measurements, and a gap."""
    samples = samples.copy()
    samples[300:310, 2] = np.nan
    samples[700, 2] += 500.0
    samples[1500:, 0] += 1.0
    return samples


def stepped(session, samples):
    return [session.step(*row) for row in samples.tolist()]


class Numbers(InFolder):
    def assert_estimates_equal(self, found, wanted):
        for name in ("y_pred", "innovation", "innovation_sd", "nis", "status", "values", "sd"):
            self.assert_same(getattr(found, name), getattr(wanted, name), name)

    def test_run_is_steps_one_by_one(self):
        samples = with_faults(armukf.read_record(RECORD))
        rows = armukf.Session().run(samples)
        self.assertEqual(set(rows.status.tolist()), {armukf.Status.OK, armukf.Status.MISSING,
                                                     armukf.Status.REJECTED, armukf.Status.GAP})
        for k, e in enumerate(stepped(armukf.Session(), samples)):
            self.assert_same([e.y_pred, e.innovation, e.innovation_sd, e.nis],
                             [rows.y_pred[k], rows.innovation[k], rows.innovation_sd[k], rows.nis[k]], k)
            self.assert_same(e.values, rows.values[k], k)
            self.assert_same(e.sd, rows.sd[k], k)
            self.assertEqual(e.status, rows.status[k])

    def test_run_is_what_the_program_writes(self):
        for words in ((), ("--filter", "ekf"), ("--effect", "torque_bias", "--free", "J")):
            model = armukf.Model()
            if "--effect" in words:
                model.add_effect("torque_bias").free("J")
            session = armukf.Session(model, filter="ekf" if "ekf" in words else None)
            found = session.run(armukf.read_record(RECORD)).to_pandas()
            wanted = columns(program("estimate", RECORD, "--quiet", *words))
            self.assertEqual(list(found), list(wanted))
            for name, column in wanted.items():
                self.assert_same(found[name], column, name)

    def test_a_run_in_parts_is_the_whole_run(self):
        samples = armukf.read_record(RECORD)
        session = armukf.Session()
        parts = [session.run(part) for part in (samples[:1], samples[1:999], samples[999:999], samples[999:])]
        whole = armukf.Session().run(samples)
        self.assert_same(np.concatenate([part.values for part in parts]), whole.values)
        self.assertEqual([len(part) for part in parts], [1, 998, 0, len(samples) - 999])

    def test_parameters_are_those_of_the_last_sample(self):
        session = armukf.Session()
        rows = session.run(armukf.read_record(RECORD))
        for name in session.model.unknowns:
            found = session.parameters[name]
            self.assertEqual((found.value, found.known), (rows[name][-1], False))
            self.assertAlmostEqual(found.sd / rows.sd_of(name)[-1], 1.0)
            self.assertGreaterEqual(found.sd, found.sd_model * (1 - 1e-12))
        self.assertEqual((session.parameters["J"].sd, session.parameters["J"].unit), (0.0, "kg.m^2"))
        sd = np.sqrt(np.diag(session.covariance))
        self.assert_same(sd.round(12), [round(session.parameters[n].sd, 12) for n in session.model.unknowns])

    def test_a_saved_belief_goes_on_bit_by_bit(self):
        samples = armukf.read_record(RECORD)
        first = armukf.Session()
        first.run(samples[:1000])
        again = armukf.Session()
        again.load(first.save())
        self.assert_estimates_equal(again.run(samples[1000:]), first.run(samples[1000:]))

    def test_a_belief_that_does_not_fit_changes_nothing(self):
        samples = armukf.read_record(RECORD)
        session, other = armukf.Session(), armukf.Session(filter="ekf")
        session.run(samples[:500])
        other.run(samples[:500])
        saved = session.save()
        for bytes_ in (other.save(), saved[:-1], b"", saved[:-1] + bytes([saved[-1] ^ 1])):
            with self.assertRaises(armukf.InputError):
                session.load(bytes_)
        self.assertEqual(session.save(), saved)

    def test_who_starts_with_its_model_goes_on(self):
        samples = armukf.read_record(RECORD)
        session = armukf.Session()
        session.run(samples)
        self.assertNotIn("belief", session.model.settings)  # of so few seconds only values count
        for _ in range(8):
            session.expect_new_clock()
            session.run(samples)
        again = armukf.Session(session.model)
        self.assertIn("belief", session.model.settings)
        for name in again.model.unknowns:  # to the last bit or two: the filters go by logarithms
            self.assertAlmostEqual(again.model[name] / session.model[name], 1.0, delta=1e-15)

    def test_a_new_clock_is_a_gap(self):
        samples = armukf.read_record(RECORD)
        session = armukf.Session()
        session.run(samples)
        session.expect_new_clock()
        self.assertEqual(session.step(0.0, 0.0, 1.0).status, armukf.Status.GAP)


class Refusals(InFolder):
    def test_what_is_no_array_of_samples_is_said(self):
        samples = armukf.read_record(RECORD)
        run = armukf.Session().run
        self.refused("samples: must be a NumPy array, not list", run, samples.tolist())
        self.refused("samples: must hold float64, not float32; see numpy.ndarray.astype", run,
                     samples.astype(np.float32))
        self.refused("samples: must hold float64, not >f8; see numpy.ndarray.astype", run,
                     samples.astype(">f8"))
        for wrong in (samples[:, 0].copy(), samples[:, :2].copy(), samples.T, np.zeros((2, 3, 3))):
            self.refused("samples: must have shape (n, 3), a row of t, u, y per sample, not "
                         f"{wrong.shape}", run, wrong)
        for wrong in (np.asfortranarray(samples), samples[::2], samples[::-1]):
            self.refused("samples: must be in C order, row by row; see numpy.ascontiguousarray", run, wrong)
        unaligned = np.frombuffer(b"0" + samples.tobytes(), np.uint8)[1:].view(float).reshape(-1, 3)
        self.refused("samples: must be in C order, row by row; see numpy.ascontiguousarray", run, unaligned)

    def test_numbers_that_no_sample_has_are_said_and_change_nothing(self):
        samples = armukf.read_record(RECORD)
        session = armukf.Session()
        session.run(samples[:100])
        before = session.save()
        for row, column, value, message in (
                (150, 1, np.nan, "samples[50]: u: nan is not a finite number"),
                (150, 1, np.inf, "samples[50]: u: inf is not a finite number"),
                (100, 0, np.nan, "samples[0]: t: nan is not a finite number"),
                (199, 2, -np.inf, "samples[99]: y: -inf is not a finite number"),
                (121, 0, samples[120, 0], "samples[21]: t: time repeats: 0.06 s after 0.06 s"),
                (100, 0, 0.01, "samples[0]: t: time goes back: 0.01 s after 0.0495 s")):
            wrong = samples[:200].copy()
            wrong[row, column] = value
            self.refused(message, session.run, wrong[100:])
        self.refused("sample[0]: u: nan is not a finite number", session.step, 1.0, np.nan, 0.0)
        self.refused("sample[0]: t: time repeats: 0.0495 s after 0.0495 s", session.step, 0.0495, 0.0, 0.0)
        self.assertEqual(session.save(), before)

    def test_what_is_no_number_is_a_type_error(self):
        with self.assertRaises(TypeError):
            armukf.Session().step("now", 0.0)
        self.refused("set:1: filter.kind: must be a string", armukf.Session, filter=3)

    def test_a_model_may_go_or_change_while_a_session_runs(self):
        samples = armukf.read_record(RECORD)
        model = armukf.Model()
        session = armukf.Session(model)
        model.set(k_a=1.0).fix("a_m").add_effect("backlash")
        del model
        gc.collect()
        self.assert_same(session.run(samples).values, armukf.Session().run(samples).values)
        with self.assertRaises(AttributeError):  # one that was never made
            armukf.Session(armukf.Model.__new__(armukf.Model))


# Prints, in bytes: what a run of 200000 samples returns, and by how much memory has grown at its peak.
PEAK = """
import json, resource, numpy as np, armukf
samples = np.zeros((200_000, 3))
samples[:, 0] = 5e-4 * np.arange(len(samples))
session = armukf.Session()
session.run(samples[:1000])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
rows = session.run(samples[1000:])
own = [rows.values, rows.sd, rows.status, rows.y_pred, rows.innovation, rows.innovation_sd, rows.nis]
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps([sum(a.nbytes for a in own), 1024 * (peak - before)]))
"""


class Memory(unittest.TestCase):
    def test_samples_are_read_where_they_lie(self):
        samples = armukf.read_record(RECORD)
        rows = armukf.Session().run(samples)
        for column in (rows.t, rows.u, rows.y):
            self.assertTrue(np.shares_memory(column, samples))

    def test_results_are_contiguous_and_outlive_the_session(self):
        session = armukf.Session()
        rows = session.run(armukf.read_record(RECORD))
        wanted = rows.values.copy()
        del session
        gc.collect()
        for array in (rows.values, rows.sd, rows.y_pred, rows.nis, rows.status):
            self.assertTrue(array.flags.c_contiguous and array.flags.writeable)
            self.assertFalse(array.flags.owndata)  # NumPy holds what C++ has written
        np.testing.assert_array_equal(rows.values, wanted)

    def test_memory_grows_by_the_results_alone(self):
        done = subprocess.run([sys.executable, "-c", PEAK], capture_output=True, text=True, check=True)
        own, grown = json.loads(done.stdout)
        # A second copy would double it; a tenth is the allocator's.
        self.assertLess(grown, 1.1 * own + 2e6)


class Threads(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.samples = armukf.simulate(samples=400_000).samples  # half a second and more of work

    def test_others_go_on_during_a_run(self):
        runner = threading.Thread(target=armukf.Session().run, args=(self.samples,))
        begin = time.monotonic()
        pauses, last = [], begin
        runner.start()
        while runner.is_alive():
            time.sleep(0.001)
            now = time.monotonic()
            pauses.append(now - last)
            last = now
        # With the lock held this thread would get on once or twice, at the ends of stretches.
        self.assertGreater(len(pauses), 50)
        self.assertLess(max(pauses), 0.5 * (last - begin))

    def test_sessions_at_once_are_as_one_by_one(self):
        part, found = self.samples[:100_000], {}

        def run(name):
            found[name] = armukf.Session(filter=name).run(part).values
        threads = [threading.Thread(target=run, args=(name,)) for name in ("ukf", "ekf", "ckf")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for name, values in found.items():
            np.testing.assert_array_equal(values, armukf.Session(filter=name).run(part).values)
        self.assertEqual(len(found), 3)

    def test_a_session_works_for_one_thread_at_a_time(self):
        session = armukf.Session()
        runner = threading.Thread(target=session.run, args=(self.samples,))
        runner.start()
        time.sleep(0.05)
        for job in (lambda: session.step(1e6, 0.0), lambda: session.run(self.samples), session.save,
                    lambda: session.model, lambda: session.parameters):
            with self.assertRaisesRegex(RuntimeError, "^the session runs in another thread$"):
                job()
        runner.join()
        self.assertEqual(session.step(1e6, 0.0).status, armukf.Status.GAP)

    def test_interrupts_end_a_run(self):
        def interrupt(*_):
            raise KeyboardInterrupt
        before = signal.signal(signal.SIGALRM, interrupt)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        session = armukf.Session()
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with self.assertRaises(KeyboardInterrupt):
            session.run(self.samples)
        # It has not come to the last sample, and can go on.
        self.assertEqual(session.step(self.samples[-1, 0], 0.0).status, armukf.Status.GAP)


class Results(unittest.TestCase):
    def test_an_estimate_is_found_by_name(self):
        session = armukf.Session()
        belief = session.step(0.0, 0.0, 1.0)
        self.assertEqual((session.names[1:3], session.names[-1]), (("twist_arm", "speed_motor"), "d_a"))
        self.assertEqual(session.units[1:6], ("rad", "rad/s", "rad/s", "rad/s", "-"))
        self.assertEqual(belief["a_m"], belief.values[5])
        self.assertEqual(belief.status.name, "OK")
        self.assertTrue(np.isnan(session.step(0.001, 0.0).y))
        with self.assertRaisesRegex(KeyError, "no 'k_b'; there are: twist_gear, .*, d_a"):
            belief["k_b"]

    def test_results_show_themselves(self):
        session = armukf.Session()
        belief = session.step(0.0, 0.0, 1.0)
        rows = session.run(armukf.read_record(RECORD)[1:])
        for result in (session, belief, rows, session.run(np.empty((0, 3)))):
            self.assertRegex(result._repr_html_(), "^<table>.*</table>$")
        self.assertIn("<td style='text-align: left'>k_a</td>", rows._repr_html_())


if __name__ == "__main__":
    unittest.main()
