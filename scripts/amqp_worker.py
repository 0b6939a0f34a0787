#!/usr/bin/python3
"""Estimates many arms whose samples come through RabbitMQ; as many workers as one likes share them out.

    amqp_worker.py --declare arms.0,arms.1,arms.2             the exchange `arms` and its queues, once
    amqp_worker.py --queues arms.0,arms.1,arms.2 --state DIR [-- OPTION OF armukf ...]

A sample is a message `arm,t,u,y` to the exchange, a consistent-hash one, with the arm's name as routing
key, so that an arm's samples all go to one queue. Each queue has one active consumer: of its workers the
one that came first; when it dies, the broker gives the queue, with what was not acknowledged, to the next.
Give each worker the queues in an order of its own, and all of them the same DIR (on one machine, or on a
disk that they share).

A worker takes what has come within --every-s and lets armukf go on from the queue's checkpoint with it.
Rows and new checkpoint take their place in DIR together; then the rows go to --output, as one message of
CSV with the id QUEUE.NUMBER; then the samples are acknowledged. Whoever dies in between is followed by one
who sends the rows that lie in DIR once more, under the same id, and to whom samples that the checkpoint
holds are old: each is estimated once, and who reads the output passes over an id that was there.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pika
import pika.exceptions

ROOT = Path(__file__).resolve().parent.parent
EXCHANGE = "arms"
HEADER = "arm,t,u,y\n"


class Partition:
    """One queue's arms: what has come of them, and what is believed of them, in a folder."""

    def __init__(self, channel, queue, options):
        self.channel = channel
        self.queue = queue
        self.options = options
        self.folder = Path(options.state, queue)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.current = self.folder / "current"  # a link to the last batch's folder
        self.rows = []
        self.last_tag = 0
        self.begun = False
        channel.confirm_delivery()
        channel.basic_qos(prefetch_count=options.most)
        channel.basic_consume(queue, self.take)

    def take(self, _channel, method, _properties, body):
        self.rows.append(body.decode())
        self.last_tag = method.delivery_tag

    def work(self):
        """Estimates what has come, sends the rows, and only then acknowledges the samples."""
        if not self.rows:
            return
        if not self.begun:
            self.begun = True
            self.follow()
        self.replace_current(self.estimated())
        self.send()
        self.channel.basic_ack(self.last_tag, multiple=True)
        self.rows.clear()

    def follow(self):
        """Whoever had the queue before may have died before the rows were sent, or in mid-work."""
        for left in self.folder.glob("at_work_*"):
            shutil.rmtree(left, ignore_errors=True)
        if self.current.exists():
            self.send()

    def estimated(self):
        """Rows and checkpoint of what has come, in a folder of their own."""
        batch = Path(tempfile.mkdtemp(dir=self.folder, prefix="at_work_"))
        words = [self.options.program, "-", "--key", "arm", "--quiet", "--checkpoint", batch / "belief"]
        words += ["--resume", self.current / "belief"] if self.current.exists() else []
        with (batch / "rows").open("w") as rows:
            subprocess.run([*map(str, words), *self.options.words], input=HEADER + "\n".join(self.rows) + "\n",
                           text=True, stdout=rows, check=True)
        return batch

    def replace_current(self, batch):
        before = self.folder / f"batch.{self.number()}"
        done = self.folder / f"batch.{self.number() + 1}"
        shutil.rmtree(done, ignore_errors=True)  # of one who died before it was the current one
        batch.rename(done)
        link = self.folder / f"link.{os.getpid()}"
        link.unlink(missing_ok=True)
        link.symlink_to(done.name)
        link.replace(self.current)
        shutil.rmtree(before, ignore_errors=True)

    def number(self):
        return int(os.readlink(self.current).split(".")[-1]) if self.current.is_symlink() else 0

    def send(self):
        """The current batch's rows."""
        self.channel.basic_publish("", self.options.output, (self.current / "rows").read_bytes(),
                                   pika.BasicProperties(message_id=f"{self.queue}.{self.number()}", delivery_mode=2))


def declare(channel, queues, output):
    channel.exchange_declare(EXCHANGE, "x-consistent-hash", durable=True)
    for queue in queues:
        channel.queue_declare(queue, durable=True, arguments={"x-single-active-consumer": True})
        channel.queue_bind(queue, EXCHANGE, routing_key="10")  # its weight
    channel.queue_declare(output, durable=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--url", default="amqp://localhost", help="the broker")
    parser.add_argument("--declare", metavar="QUEUE,...", help="make exchange and queues, and end")
    parser.add_argument("--queues", metavar="QUEUE,...", help="to work on, the own one first")
    parser.add_argument("--state", type=Path, default=Path("state"), metavar="DIR")
    parser.add_argument("--output", default="beliefs", metavar="QUEUE", help="where the rows go")
    parser.add_argument("--every-s", type=float, default=0.5)
    parser.add_argument("--most", type=int, default=50_000, help="samples of a queue in memory, at most")
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/armukf"))
    parser.add_argument("words", nargs="*", metavar="OPTION of armukf")
    options = parser.parse_args()
    connection = pika.BlockingConnection(pika.URLParameters(options.url))
    if options.declare:
        declare(connection.channel(), options.declare.split(","), options.output)
        return 0
    if not options.queues:
        parser.error("--queues or --declare")
    partitions = [Partition(connection.channel(), queue, options) for queue in options.queues.split(",")]
    while True:
        connection.sleep(options.every_s)
        for partition in partitions:
            partition.work()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (pika.exceptions.AMQPError, OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"amqp_worker: {error or type(error).__name__}")
    except KeyboardInterrupt:
        sys.exit(130)
