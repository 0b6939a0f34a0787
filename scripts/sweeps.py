"""Many runs of armukf: on this machine, or spread over a Dask cluster; what is done is kept."""

import json
import logging
import math
import os
import random
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import cloudpickle

from published import TRUTH

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "build/release/bin/armukf"
WRONG_INPUT = 2  # exit status of armukf

INERTIA = 0.03291699877416  # kg.m^2, J of the published arm

# Published start values, and how far apart random arms and start values lie: sd of the logarithm.
START = {"a_m": 0.17910964111956, "a_g": 0.61206166914114, "k_g1": 20.59269827430799,
         "k_g3": 10.0, "d_g": 0.0624181404729, "k_a": 20.23072060978318, "d_a": 0.00987527995798}
START_SPREAD = {"a_m": 0.2, "a_g": 0.1, "k_g1": 0.15, "k_g3": 0.5, "d_g": 0.4, "k_a": 0.3, "d_a": 0.5}

# Functions of these scripts travel to workers that do not have them.
cloudpickle.register_pickle_by_value(sys.modules[__name__])


class Trouble(Exception):
    """What the user must know; the message says it."""


class Failed(Trouble):
    """armukf could not do what it was asked for, although it was asked rightly."""


def armukf(program, *words):
    """The JSON that a command prints. Failed where it ended by a fault of its own or by a signal."""
    prints = [] if "--score" in words else ["--json", "-"]
    done = subprocess.run([str(program), *map(str, words), *prints, "--quiet"], capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        kind = Trouble if done.returncode == WRONG_INPUT else Failed
        raise kind(done.stderr.strip() or f"{program}: exit status {done.returncode}")
    return json.loads(done.stdout)


def simulate(program, path, seed, noise, disturbance=0.0, values=None, samples=None):
    """A record of the published arm, or of one with these values; of the published length if none is given."""
    command = [str(program), "simulate", "-o", str(path), "--seed", str(seed), "--sensor-noise",
               str(noise), "--torque-disturbance", str(disturbance), "--quiet"]
    command += ["--samples", str(samples)] if samples else []
    command += [word for name, value in (values or {}).items() for word in ("--set", f"{name}={value!r}")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Trouble(done.stderr.strip() or f"{program}: exit status {done.returncode}")
    return path


def drawn_about(values, spread, draw):
    """Parameters drawn about these; the shares leave something to the arm."""
    while True:
        drawn = {p: value * math.exp(draw.gauss(0, spread[p])) for p, value in values.items()}
        if drawn["a_m"] + drawn["a_g"] <= 0.95:
            return drawn


def random_arm(number, spread=0.2):
    """Values of arm `number`; arm 0 is the published one."""
    if number == 0:
        return dict(TRUTH)
    draw = random.Random(f"arm {number}")
    return drawn_about(TRUTH, {p: min(spread, 0.1) if p == "a_g" else spread for p in TRUTH}, draw)


def finite(numbers):
    """Whether all of them are; JSON says null of one that is not."""
    return all(v is not None and math.isfinite(v) for v in numbers)


def physical(result):
    """Whether an estimate's parameters can be those of an arm, and be simulated."""
    p = {name: entry["value"] for name, entry in result["parameters"].items()}
    if not finite([*p.values(), result["simulation"]["fit_percent"]]):
        return False
    return min(p.values()) >= 0 and p["a_m"] + p["a_g"] < 1


class Ledger:
    """Results by key, in a file that a killed run leaves whole; without a path they are only held."""

    def __init__(self, path=None):
        self.path = Path(path) if path else None
        self.results = {}
        if self.path and self.path.exists():
            for line in self.path.read_text().splitlines():
                try:
                    entry = json.loads(line)
                except json.JSONDecodeError:
                    continue  # the line that the kill cut short
                self.results[entry["key"]] = entry["result"]

    def add(self, key, result):
        self.results[key] = result
        if self.path:
            with self.path.open("a") as file:
                file.write(json.dumps({"key": key, "result": result}) + "\n")

    def kept(self):
        return f"{len(self.results)} results are kept in {self.path}" if self.path else \
            "nothing is kept: give --state FILE"


class Progress:
    """Runs done and time left, on a terminal."""

    def __init__(self, label, total):
        self.label, self.total, self.done, self.begin = label, total, 0, time.monotonic()
        self.visible = sys.stderr.isatty() and total > 0

    def add(self):
        self.done += 1
        if self.visible:
            left = (time.monotonic() - self.begin) * (self.total / self.done - 1)
            print(f"\r{self.label}: {self.done} of {self.total}, {left:.0f} s left  ", end="",
                  file=sys.stderr, flush=True)

    def wipe(self):
        if self.visible:
            print("\r" + " " * 78 + "\r", end="", file=sys.stderr, flush=True)


class Pool:
    """A Dask client; map() gives results in the order of the items whatever the workers do."""

    LOST_AFTER_S = 10.0

    def __init__(self, client, where):
        self.client, self.where = client, where

    def map(self, function, items, ledger=None, label="runs"):
        """function(item) for items that JSON can hold; those in the ledger are not run again."""
        from dask.distributed import wait
        ledger = ledger or Ledger()
        keys = [json.dumps([function.__name__, item], sort_keys=True) for item in items]
        left = {}  # a key twice is run once
        for key, item in zip(keys, items):
            if key not in ledger.results:
                left.setdefault(key, item)
        progress = Progress(label, len(left))
        futures = {self.client.submit(function, item, pure=False, retries=2): key
                   for key, item in left.items()}
        heard = time.monotonic()
        while futures:
            try:
                done = wait(list(futures), timeout=1.0, return_when="FIRST_COMPLETED").done
            except Exception as error:  # TimeoutError, or what a lost connection looks like
                done = ()
                timed_out = "Timeout" in type(error).__name__
            else:
                timed_out = False
            if self.client.status == "running" and (done or timed_out):
                heard = time.monotonic()
            if time.monotonic() - heard > self.LOST_AFTER_S:
                raise Trouble(f"{self.where} went away; {ledger.kept()}")
            for future in done:
                key = futures.pop(future)
                if future.status == "cancelled" or future.status == "lost":
                    raise Trouble(f"{self.where} went away; {ledger.kept()}")
                ledger.add(key, future.result())
                progress.add()
        progress.wipe()
        return [ledger.results[key] for key in keys]


@contextmanager
def pool(workers=None, scheduler=None):
    """Workers on this machine, or those of the scheduler at this address."""
    logging.disable(logging.ERROR)  # what goes wrong is said in one line
    import dask
    from dask.distributed import Client, LocalCluster
    dask.config.set({"distributed.comm.timeouts.connect": "5s"})
    if scheduler:
        try:
            client = Client(scheduler, timeout=5)
        except (OSError, ValueError, TimeoutError) as error:
            raise Trouble(f"no Dask scheduler at {scheduler}: {str(error).splitlines()[0]}") from error
        if not client.scheduler_info()["workers"]:
            client.close()
            raise Trouble(f"the Dask scheduler at {scheduler} has no workers")
        cluster, where = None, f"the Dask scheduler at {scheduler}"
    else:
        # armukf is a program of its own: threads that wait for it are enough.
        cluster = LocalCluster(n_workers=1, threads_per_worker=workers or os.cpu_count(),
                               processes=False, dashboard_address=":0")
        client, where = Client(cluster), "the local Dask cluster"
    try:
        yield Pool(client, where)
    finally:
        try:
            client.close(timeout=2)
            if cluster:
                cluster.close(timeout=2)
        except Exception:  # the cluster may be gone: there is nothing left to close
            pass


def add_options(parser):
    """What every sweep's command line has."""
    parser.add_argument("--workers", type=int, help="runs at a time on this machine; by default its cores")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, tcp://HOST:PORT; its "
                        "workers see program and files by the same paths")
    parser.add_argument("--state", metavar="FILE", help="keep what is done; the same command goes on there")
    parser.add_argument("--program", default=str(PROGRAM), help="armukf")
    parser.add_argument("--json", metavar="FILE", help="write the results; - is standard output")


@contextmanager
def whole_file(path):
    """A file that is written whole, or stays what it was."""
    unfinished = Path(f"{path}.tmp")
    try:
        with unfinished.open("w", encoding="utf-8", newline="") as file:
            yield file
        unfinished.replace(path)
    except OSError as error:
        raise Trouble(f"{path}: {error.strerror}") from error


def write_json(path, content):
    text = json.dumps(content, indent=2) + "\n"
    if path == "-":
        print(text, end="")
    elif path:
        with whole_file(path) as file:
            file.write(text)


def run_script(main):
    """Exit status 2 and one line for what the user must know."""
    try:
        sys.exit(main())
    except Trouble as trouble:
        print(f"{Path(sys.argv[0]).name}: {trouble}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
