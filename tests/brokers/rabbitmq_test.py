#!/usr/bin/python3
"""Thirty arms, three workers and a real RabbitMQ: one worker is killed in mid-stream, and still every sample
is estimated once, each arm's as without a broker. Exit status 77 where RabbitMQ or pika is not installed.

    rabbitmq_test.py PROGRAM
"""

import csv
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from broker import PATIENCE_S, SKIPPED, answers, free_port, missing, simulated, started, wait_until

try:
    import pika
except ImportError:
    pika = None

WORKER = Path(__file__).resolve().parents[2] / "scripts/amqp_worker.py"
SERVER = Path("/usr/lib/rabbitmq/bin/rabbitmq-server")  # Debian's wrapper changes the user
ARMS, SAMPLES = 30, 1200
QUEUES = ["arms.0", "arms.1", "arms.2"]
STREAM_S = 6.0  # that the samples take to come
KILL_S = 3.0    # after which a worker dies


def broker_started(stack, folder, port):
    (folder / "rabbit.conf").write_text(f"listeners.tcp.1 = 127.0.0.1:{port}\n")
    (folder / "plugins").write_text("[rabbitmq_consistent_hash_exchange].\n")
    environment = os.environ | {
        "HOME": str(folder), "RABBITMQ_NODENAME": f"armukf_{port}@localhost",
        "RABBITMQ_MNESIA_BASE": str(folder / "data"), "RABBITMQ_LOG_BASE": str(folder / "log"),
        "RABBITMQ_ENABLED_PLUGINS_FILE": str(folder / "plugins"),
        "RABBITMQ_CONFIG_FILE": str(folder / "rabbit"), "RABBITMQ_PID_FILE": str(folder / "pid"),
        "RABBITMQ_DIST_PORT": str(free_port()), "ERL_EPMD_PORT": str(free_port()),
        "ERL_EPMD_ADDRESS": "127.0.0.1", "ERL_EPMD_RELAXED_COMMAND_CHECK": "1"}
    log = stack.enter_context((folder / "broker.log").open("w"))
    process = started(stack, [SERVER], env=environment, stdout=log, stderr=log, start_new_session=True)
    stack.callback(subprocess.run, ["epmd", "-kill"], env=environment, stdout=subprocess.DEVNULL)
    stack.callback(os.killpg, process.pid, signal.SIGKILL)
    wait_until("the broker", lambda: "completed with" in (folder / "broker.log").read_text()
               and answers(port))


def all_samples(program, folder):
    """(arm, row) in the order in which they come, and what is estimated of them without a broker."""
    records = {}
    for i in range(ARMS):
        lines = simulated(program, folder / "record.csv", SAMPLES, seed=i + 1).read_text().splitlines()
        records[f"arm{i:02}"] = [line for line in lines if line[0].isdigit()]
    samples = [(arm, f"{arm},{rows[k]}") for k in range(SAMPLES) for arm, rows in records.items()]
    text = "arm,t,u,y\n" + "\n".join(row for _, row in samples) + "\n"
    wanted = subprocess.run([program, "-", "--key", "arm", "--quiet"], input=text, text=True, capture_output=True,
                            check=True).stdout.splitlines()[1:]
    return samples, sorted(wanted)


def publish(channel, samples, then):
    """Over STREAM_S; then() is called after KILL_S."""
    begin = time.monotonic()
    for i, (arm, row) in enumerate(samples):
        channel.basic_publish("arms", arm, row, pika.BasicProperties(delivery_mode=2))
        due = begin + STREAM_S * i / len(samples)
        if i % 100 == 0 and due > time.monotonic():
            time.sleep(due - time.monotonic())
        if then and time.monotonic() - begin > KILL_S:
            then()
            then = None
    return then is None


def collected(channel, count):
    """Rows of all batches, one that comes twice once; until there are so many or nothing more comes."""
    batches = {}
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end and sum(map(len, batches.values())) < count:
        _, properties, body = channel.basic_get("beliefs", auto_ack=True)
        if body is None:
            time.sleep(0.1)
        else:
            batches[properties.message_id] = body.decode().splitlines()[1:]
    time.sleep(1.0)  # whatever should not come
    while (got := channel.basic_get("beliefs", auto_ack=True))[2] is not None:
        batches[got[1].message_id] = got[2].decode().splitlines()[1:]
    return sorted(row for rows in batches.values() for row in rows)


def main():
    program = Path(sys.argv[1]).resolve()
    if not pika or not SERVER.exists() or missing("erl"):
        print("skipped: rabbitmq-server and python3-pika are not installed")
        return SKIPPED
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder, port = Path(name), free_port()
        broker_started(stack, folder, port)
        url = f"amqp://127.0.0.1:{port}"
        samples, wanted = all_samples(program, folder)
        common = [WORKER, "--url", url, "--program", program, "--state", folder / "state"]
        subprocess.run([*map(str, common), "--declare", ",".join(QUEUES)], check=True)
        workers = []
        for i in range(len(QUEUES)):
            own_first = QUEUES[i:] + QUEUES[:i]
            workers.append(started(stack, [*common, "--queues", ",".join(own_first), "--every-s", 0.2]))
            wait_until("a worker", lambda q=own_first[0]: (folder / "state" / q).exists())
            time.sleep(0.3)  # it comes first to its own queue
        connection = stack.enter_context(pika.BlockingConnection(pika.URLParameters(url)))
        channel = connection.channel()
        killed = publish(channel, samples, workers[1].kill)
        found = collected(channel, len(wanted))
        alive = [w.poll() is None for w in workers]
    if not killed or alive != [True, False, True]:
        sys.exit(f"rabbitmq_test: not what was to be tried, workers alive: {alive}")
    if found != wanted:
        twice = len(found) - len(set(found))
        sys.exit(f"rabbitmq_test: {len(found)} rows instead of {len(wanted)}, {twice} twice, "
                 f"{len(set(wanted) - set(found))} missing or others")
    arms = {row[0] for row in csv.reader(found)}
    print(f"{len(found)} rows of {len(arms)} arms, each once and the same, one of three workers killed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
