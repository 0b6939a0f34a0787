#!/usr/bin/python3
"""Tracks: samples as they come, what becomes of them, checkpoints."""

import unittest

import numpy as np
from support import RECORD, InFolder

import armukf
from armukf import Fate


def believed(track, samples):
    """What a track says of the samples, one by one."""
    found = []
    for row in samples.tolist():
        track.put(*row)
        found += track.ready()
    return found


class Tracks(InFolder):
    def setUp(self):
        super().setUp()
        self.samples = armukf.read_record(RECORD)[:600]

    def assert_same_beliefs(self, found, wanted):
        self.assertEqual([e.t for e in found], [e.t for e in wanted])
        for a, b in zip(found, wanted):
            self.assert_same(a.values, b.values, a.t)
            self.assert_same(a.sd, b.sd, a.t)

    def test_a_track_of_samples_in_order_is_a_session(self):
        session = armukf.Session()
        wanted = [session.step(*row) for row in self.samples.tolist()]
        self.assert_same_beliefs(believed(armukf.Track(), self.samples), wanted)

    def test_samples_that_come_late_are_sorted_in(self):
        order = np.arange(len(self.samples))
        order[100:103] = [102, 100, 101]
        track = armukf.Track(reorder_s=0.005)
        found = believed(track, self.samples[order])
        track.end()
        found += track.ready()
        self.assert_same_beliefs(found, believed(armukf.Track(), self.samples))
        self.assertEqual(track.counts, armukf.FateCounts(0, 0, 0, 0))

    def test_what_cannot_be_taken_is_told_and_counted(self):
        track = armukf.Track()
        believed(track, self.samples[:10])
        t = float(self.samples[9, 0])
        self.assertEqual(track.put(t, 0.0, 1.0), Fate.REPEATED)
        self.assertEqual(track.put(t - 0.0007, 0.0, 1.0), Fate.LATE)
        self.assertEqual(track.put(t + 1e6, 0.0, 1.0), Fate.ASTRAY)
        self.assertEqual(track.put(*self.samples[10].tolist()), Fate.TAKEN)
        self.assertEqual((track.counts.late, track.counts.repeated, track.counts.astray), (1, 1, 1))

    def test_the_same_stream_may_be_put_again_after_a_checkpoint(self):
        whole = believed(armukf.Track(), self.samples)
        first = armukf.Track()
        believed(first, self.samples[:250])
        second = armukf.Track()
        second.load(first.save())
        self.assert_same_beliefs(believed(second, self.samples), whole[250:])

    def test_what_is_believed_starts_another(self):
        track, session = armukf.Track(), armukf.Session()
        believed(track, self.samples)
        session.run(self.samples)
        self.assertEqual(track.parameters, session.parameters)
        self.assertEqual(str(track.model), str(session.model))

    def test_nonsense_is_refused(self):
        track = armukf.Track()
        self.refused("sample[0]: t: nan is not a finite number", track.put, float("nan"), 0.0, 0.0)
        self.refused("reorder_s: must be at least 0 and finite, not -1", armukf.Track, reorder_s=-1)
        with self.assertRaises(armukf.InputError):
            track.load(b"no checkpoint")


if __name__ == "__main__":
    unittest.main()
