#!/usr/bin/python3
"""What the live page's server keeps and sends, without a browser: server_test.py PROGRAM

Exit status 77 where aiohttp is not installed."""

import asyncio
import json
import math
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from array import array
from pathlib import Path

try:
    import aiohttp
except ImportError:
    print("skipped: python3-aiohttp is not installed")
    sys.exit(77)

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
LIVE = SCRIPTS / "live.py"
PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin/armukf"

from live_columns import InputError, unit_of  # noqa: E402
from live_history import CAPACITY, FEWEST, MERGED, capacity_among  # noqa: E402
from live_stream import LATE_S, MOST_ARMS, MOST_EVENTS, Events, Stream  # noqa: E402

HEADER = "t,y,y_pred,innovation,innovation_sd,nis,status,twist_gear,speed_motor,k_a,twist_gear_sd,speed_motor_sd,k_a_sd"
EFFECTS = """torque_bias torque_gain torque_ripple torque_ripple_commanded input_delay drive_lag drive_lag_second_order friction_parameters coulomb_asymmetry
    gear_friction arm_friction load_dependent_friction thermal_friction presliding_friction presliding_friction_lugre backlash gear_hysteresis
    gear_damping_quadratic arm_stiffness_cubic flexible_mode flexible_mode_gear flexible_mode_arm:2 gravity
    payload_change sensor_lag speed_ripple speed_ripple_constant friction_curve gear_spring_curve arm_spring_curve
    torque_curve angle_curve external_torque friction_change friction_ripple arm_backlash arm_hysteresis sensor_coupling
    thermal_torque thermal_torque_heated thermal_damping external_torque_arm gear_stiffness_ripple transmission_error pose_inertia
    thermal_friction_heated thermal_friction_cold gear_stiffness_change arm_stiffness_change gear_slip gear_relaxation torque_limit torque_slew friction_lag
    drive_notch sensor_gain sensor_curve""".split()
PATIENCE_S = 20.0


def row(t, innovation=0.0, nis=1.0, status="ok", state=0.0, k_a=12.0):
    return f"{t:.6g},0,0,{innovation},0.1,{nis},{status},{state},{-state},{k_a},0.01,0.02,0.5"


def fed(lines, header=HEADER):
    stream = Stream()
    stream.feed("".join(f"{line}\n" for line in [header, *lines]).encode(), 0.0)
    return stream


def ended(lines, header=HEADER):
    stream = fed(lines, header)
    stream.end()
    return stream


def bins_of(stream, arm=b""):
    """As dictionaries, oldest first."""
    return [dict(zip(stream.layout.fields, bin)) for bin in stream.arms[arm].history.all()]


class Thinning(unittest.TestCase):
    def test_bin_keeps_what_every_row_says_at_its_extreme(self):
        draw = random.Random(1)
        rows = [(k / 2000, draw.gauss(0, 1), draw.random(), draw.gauss(0, 1)) for k in range(100_000)]
        bins = bins_of(ended([row(t, i, n, state=s) for t, i, n, s in rows]))
        self.assertEqual(sum(bin["rows"] for bin in bins), len(rows))
        begin = 0
        for bin in bins:
            end = begin + int(bin["rows"])
            _, innovations, nis, states = zip(*rows[begin:end])
            self.assertAlmostEqual(bin["t"], rows[end - 1][0])
            self.assertEqual((bin["innovation_min"], bin["innovation_max"]), (min(innovations), max(innovations)))
            self.assertEqual((bin["twist_gear_min"], bin["twist_gear_max"]), (min(states), max(states)))
            self.assertEqual((bin["twist_gear"], bin["k_a"], bin["k_a_sd"]), (states[-1], 12.0, 0.5))
            self.assertAlmostEqual(bin["nis"], sum(nis) / len(nis))
            begin = end
        self.assertTrue(all(abs(bin["rows"] - 40) <= 1 for bin in bins[1 - CAPACITY:]))  # 20 ms at 2 kHz
        self.assertTrue(all(abs(bin["rows"] - 40 * MERGED) <= 1 for bin in bins[:50]))

    def test_one_outlier_is_seen_however_old(self):
        rows = [row(k / 10, 77.0 if k == 5 else 0.1) for k in range(60_000)]
        oldest = bins_of(ended(rows))[0]
        self.assertGreater(oldest["rows"], 15)
        self.assertEqual(oldest["innovation_max"], 77.0)

    def test_where_a_row_is_cut_makes_no_difference(self):
        text = "".join(f"{line}\n" for line in [HEADER, *(row(k / 100, k) for k in range(300))]).encode()
        whole, pieces = Stream(), Stream()
        whole.feed(text, 0.0)
        for i in range(0, len(text), 7):
            pieces.feed(text[i:i + 7], 0.0)
        self.assertEqual(whole.arms[b""].history.all(), pieces.arms[b""].history.all())

    def test_measurements_that_are_missing_or_rejected_are_counted(self):
        lines = [row(0.001), row(0.002, "nan", "nan", "missing"), row(0.003, 9, 90, "rejected"),
                 row(0.004, status="gap")]
        bin, = bins_of(ended(lines))
        self.assertEqual([bin[name] for name in ("rows", "missing", "rejected", "gap", "reset")], [4, 1, 1, 1, 0])
        self.assertEqual((bin["innovation_max"], bin["nis"]), (9.0, 92 / 3))
        nothing, = bins_of(ended([row(0.002, "nan", "nan", "missing")]))
        self.assertTrue(math.isnan(nothing["innovation_min"]) and math.isnan(nothing["nis"]))

    def test_a_bin_is_shown_soon_though_no_row_follows(self):
        stream = fed([row(0.001)])
        stream.close_late(0.9 * LATE_S)
        self.assertEqual(bins_of(stream), [])
        stream.close_late(LATE_S)
        self.assertEqual(len(bins_of(stream)), 1)

    def test_rows_that_come_again_replace_those_that_were_there(self):
        lines = [row(k / 10, 1) for k in range(100)] + [HEADER] + [row(k / 10, 2) for k in range(50, 120)]
        stream = ended(lines)
        bins = bins_of(stream)
        self.assertEqual([bin["innovation_max"] for bin in bins], [1.0] * 50 + [2.0] * 70)
        self.assertEqual([round(bin["t"] * 10) for bin in bins], list(range(120)))
        self.assertEqual(stream.malformed, 0)


class BoundedMemory(unittest.TestCase):
    def test_levels_hold_a_year_in_few_bins(self):
        stream = ended([row(k, k) for k in range(100_000)])  # each row is a bin of its own
        levels = stream.arms[b""].history.levels
        self.assertLessEqual(max(map(len, levels)), CAPACITY)
        self.assertLessEqual(len(levels), 2 + math.log(100_000 / CAPACITY, MERGED))
        year_bins = 365 * 86400 * 50
        self.assertLessEqual(CAPACITY * (2 + math.log(year_bins / CAPACITY, MERGED)), 13_000)

    def test_who_follows_the_journal_holds_the_same_bins(self):
        draw, stream = random.Random(2), fed([])
        levels, cursor = [], -1
        for k in range(20_000):
            stream.feed(f"{row(k)}\n".encode(), 0.0)
            if k == 15_000:
                stream.feed(f"{row(14_000)}\n{row(14_001)}\n".encode(), 0.0)
            if draw.random() < 0.01:
                history = stream.arms[b""].history
                bins, anew = history.since(cursor)
                cursor = history.written
                levels = take(levels, bins, anew)
                self.assertEqual([bin for level in reversed(levels) for bin in level], history.all())

    def test_many_arms_share_it(self):
        self.assertEqual((capacity_among(1), capacity_among(20)), (CAPACITY, CAPACITY))
        self.assertEqual(capacity_among(40), CAPACITY // 2)
        self.assertGreaterEqual(capacity_among(MOST_ARMS), FEWEST)
        lines = [f"arm{i},{row(k)}" for k in range(3) for i in range(MOST_ARMS + 50)]
        stream = ended(lines, "arm," + HEADER)
        self.assertEqual(len(stream.arms), MOST_ARMS)

    def test_events_and_lines_without_an_end(self):
        events = Events()
        events.feed(b'{"t":1,"what":"k_a"}\n' * (2 * MOST_EVENTS))
        self.assertEqual((len(events.newest), len(events.since(0)), len(events.since(events.count))),
                         (MOST_EVENTS, MOST_EVENTS, 0))
        stream = fed([])
        for _ in range(100):
            stream.feed(b"x" * 10_000, 0.0)
        self.assertLess(len(stream.rest), 100_000)


def take(levels, bins, anew):
    """As history.js does."""
    levels = [] if anew else levels
    for bin in bins:
        level = int(bin[0])
        levels += [[] for _ in range(level + 1 - len(levels))]
        levels[level].append(bin)
        if level and not anew:
            del levels[level - 1][:MERGED]
    return levels


class Malformed(unittest.TestCase):
    def test_lines_that_are_no_rows_are_counted_and_passed_over(self):
        good = [row(k) for k in range(10)]
        bad = ["", "nonsense", "x" + row(5), row(5) + ",1",
               row(5, "abc"), row(5, status="fine"), "nan" + row(5)[1:], "\x00\xff,,,,", "<script>alert(1)</script>"]
        stream = ended([line for pair in zip(good, bad + [""]) for line in pair])
        self.assertEqual((stream.rows, stream.malformed), (10, len(bad) - 1))  # an empty line is none
        self.assertEqual([bin["t"] for bin in bins_of(stream)], list(range(10)))

    def test_another_header_begins_anew(self):
        stream = ended([row(k) for k in range(10)] + [HEADER.replace("k_a", "d_a")] + [row(k) for k in range(5)])
        self.assertEqual((stream.layout.parameters, len(bins_of(stream))), (["d_a"], 5))

    def test_what_is_no_estimate_is_refused(self):
        with self.assertRaisesRegex(InputError, "no column innovation"):
            fed([], "t,u,y")

    def test_events_that_are_none_are_counted(self):
        events = Events()
        found = events.feed(b'{"t":1,"what":"k_a"}\nnonsense\n[1]\n{"what":1}\n{"t":NaN}\n{"t":2')
        self.assertEqual((len(found), events.malformed), (1, 4))
        self.assertEqual(len(events.feed(b"}\n")), 1)


class TableOfArms(unittest.TestCase):
    def test_worst_first_and_silence_is_worst(self):
        stream = fed([f"{arm},{row(k / 10, nis=nis)}" for k in range(20) for arm, nis in
                      (("good", 1), ("bad", 7), ("gone", 1))], "arm," + HEADER)
        stream.close_late(1.0)
        stream.feed("".join(f"{arm},{row(3, nis=nis)}\n" for arm, nis in (("good", 1), ("bad", 7))).encode(), 8.0)
        names = [judged["arm"] for judged in stream.table(9.0)]
        self.assertEqual(names, ["gone", "bad", "good"])
        stream.end()
        self.assertEqual([judged["arm"] for judged in stream.table(99.0)][0], "bad")
        json.dumps(stream.table(99.0), allow_nan=False)


class Columns(unittest.TestCase):
    def test_states_and_units_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            record = Path(folder, "record.csv")
            record.write_text("t,u,y\n0,1,0\n5e-4,1,0.1\n1e-3,1,0.2\n")
            for words in [["--free", "J"], *(["--effect", effect] for effect in EFFECTS)]:
                done = subprocess.run([PROGRAM, record, "--quiet", *words, "--json", f"{folder}/out.json"],
                                      capture_output=True, text=True, check=True)
                told = json.loads(Path(folder, "out.json").read_text())["parameters"]
                layout = fed([], done.stdout.splitlines()[0]).layout
                self.assertEqual([], [name for name in layout.parameters if name not in told], words)
                self.assertEqual([], [name for name in layout.states if name in told], words)
                for name in layout.parameters:
                    unit = told[name]["unit"].replace(".", "·").replace("^2", "²").replace("^3", "³")
                    self.assertEqual(unit_of(name), "–" if unit == "-" else unit, name)


class Server(unittest.TestCase):
    """The script as a user starts it."""

    def start(self, *words, **pipes):
        pipes.setdefault("stdin", subprocess.PIPE)
        server = subprocess.Popen([LIVE, "--port", "0", *map(str, words)], stderr=subprocess.PIPE, **pipes)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        for pipe in (server.stdin, server.stdout, server.stderr):
            if pipe:
                self.addCleanup(pipe.close)
        line = server.stderr.readline().decode()
        self.assertIn("http://127.0.0.1:", line)
        server.address = line.split()[-1]
        return server

    def rows(self, server, *lines):
        server.stdin.write("".join(f"{line}\n" for line in lines).encode())
        server.stdin.flush()

    def heard(self, server, until, **options):
        """What a browser is told, and the bins that it holds then."""
        async def listen():
            told, levels, width = {}, [], None
            async with aiohttp.ClientSession() as session, \
                    session.ws_connect(server.address + "/stream", max_msg_size=0, **options) as socket:
                async for message in socket:
                    if message.type == aiohttp.WSMsgType.TEXT:
                        told.update(json.loads(message.data))
                        width = len(told["layout"]["fields"]) if "layout" in told else None
                    elif message.type == aiohttp.WSMsgType.BINARY:
                        numbers = array("d", message.data)
                        bins = [numbers[i:i + width] for i in range(1, len(numbers), width)]
                        levels = take(levels, bins, numbers[0] == 1)
                    bins = [dict(zip(told["layout"]["fields"], b)) for level in reversed(levels) for b in level]
                    if until(told, bins):
                        return told, bins
        return asyncio.run(asyncio.wait_for(listen(), PATIENCE_S))

    def status_of(self, address, **headers):
        async def ask():
            async with aiohttp.ClientSession() as session, session.get(address, headers=headers) as answer:
                return answer.status, answer.headers.get("Content-Security-Policy", "")
        return asyncio.run(ask())

    def test_who_comes_in_mid_stream_is_told_what_was_before(self):
        server = self.start()
        self.rows(server, HEADER, *(row(k, k) for k in range(1500)))
        self.heard(server, lambda _, bins: len(bins) > 900)
        self.rows(server, *(row(k, k) for k in range(1500, 1600)))
        _, bins = self.heard(server, lambda _, bins: bins and bins[-1]["t"] == 1599)
        self.assertEqual((sum(bin["rows"] for bin in bins), bins[0]["innovation_min"]), (1600, 0.0))

    def test_a_stream_that_ends_stays_on_show(self):
        server = self.start()
        self.rows(server, HEADER, row(1), row(2, k_a=15))
        server.stdin.close()
        told, bins = self.heard(server, lambda told, bins: told["ended"] and len(bins) == 2)
        self.assertEqual((told["counts"][0], bins[-1]["k_a"]), (2, 15.0))
        self.assertIsNone(server.poll())
        server.send_signal(signal.SIGTERM)
        self.assertEqual(server.wait(PATIENCE_S), 0)

    def test_rows_pass_unchanged_and_it_ends_with_the_stream(self):
        server = self.start("--pass", "--until-end", stdout=subprocess.PIPE)
        lines = [HEADER, *(row(k) for k in range(500)), "nonsense"]
        server.stdin.write("\n".join(lines).encode())
        server.stdin.close()
        self.assertEqual(server.stdout.read().decode().split("\n"), lines)
        self.assertEqual(server.wait(PATIENCE_S), 0)

    def test_a_file_that_is_still_written_is_followed_through_rotation(self):
        with tempfile.TemporaryDirectory() as folder:
            rows, events = Path(folder, "rows.csv"), Path(folder, "events.jsonl")
            rows.write_text(f"{HEADER}\n{row(1)}\n")
            server = self.start(rows, "--follow", "--events", events)
            self.heard(server, lambda _, bins: len(bins) == 1)
            with rows.open("a") as file:
                file.write(row(2) + "\n")
            self.heard(server, lambda _, bins: len(bins) == 2)
            rows.rename(Path(folder, "old.csv"))
            rows.write_text(f"{HEADER}\n{row(3)}\n")
            events.write_text('{"t":2.5,"what":"k_a"}\n')
            told, _ = self.heard(server, lambda told, bins: len(bins) == 3 and "events" in told)
            self.assertEqual(told["events"], [{"t": 2.5, "what": "k_a"}])

    def test_a_port_in_use_and_other_wrong_input_take_one_line(self):
        with socket.socket() as taken, tempfile.TemporaryDirectory() as folder:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            record = Path(folder, "record.csv")
            record.write_text("# a record\nt,u,y\n0,0,0\n")
            for words, complaint in (
                    (["--port", port], f"port {port} is in use, perhaps by another page; --port takes another"),
                    (["nowhere.csv"], "nowhere.csv: No such file or directory"),
                    (["--port", 0, record],
                     f"{record}:2: no column innovation; is it what `armukf estimate` writes?")):
                done = subprocess.run([LIVE, *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True,
                                      text=True, timeout=PATIENCE_S, check=False)
                self.assertEqual((done.returncode, done.stderr.splitlines()[-1]), (2, f"live.py: {complaint}"))

    def test_only_its_own_page_may_look(self):
        server = self.start()
        status, policy = self.status_of(server.address)
        self.assertEqual(status, 200)
        self.assertIn("default-src 'none'", policy)
        self.assertNotIn("unsafe", policy)
        self.assertEqual(self.status_of(server.address, Host="elsewhere.example")[0], 403)
        self.assertEqual(self.status_of(server.address + "/live.py")[0], 404)
        with self.assertRaises(aiohttp.WSServerHandshakeError):
            self.heard(server, lambda *_: True, origin="http://elsewhere.example")

    def test_a_row_is_told_within_half_a_second(self):
        server = self.start()
        self.rows(server, HEADER, row(0))
        delays = []
        for k in range(1, 6):
            self.rows(server, row(k))
            begin = time.monotonic()
            self.heard(server, lambda _, bins: bins and bins[-1]["t"] == k)  # noqa: B023
            delays.append(time.monotonic() - begin)
        self.assertLess(sorted(delays)[2], 0.4)  # the middle one: others may use this machine


if __name__ == "__main__":
    unittest.main()
