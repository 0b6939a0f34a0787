"""Rows of `armukf estimate` as they come, gathered by arm; and events of its `--watch`."""

import json
import math
from array import array
from collections import deque

from live_columns import COUNTS, InputError, Layout
from live_history import MANY, History, capacity_among

BIN_S = 0.02          # of an arm's own time
LONGEST_BIN_S = 0.25  # of many arms: the page is to be half a second behind at most
LATE_S = 0.1          # of the wall clock, after which a bin is shown though it is not full
MOST_ARMS = 1000      # as `armukf --max-arms`; beyond it the one not heard for longest is forgotten
LONGEST_LINE = 1 << 16  # bytes
MOST_EVENTS = 1000    # newest ones, that are kept
RECENT_S = 10.0       # that an arm is judged by in the table of arms
SILENT_S = 5.0        # after which an arm that sends nothing is worse than any other
STATUS = {b"missing": 1, b"rejected": 2, b"gap": 3, b"reset": 4}  # places in COUNTS


def number(field):
    try:
        return float(field or "nan")
    except ValueError:
        return math.nan


def finite(value):
    """JSON has no other numbers."""
    return value if math.isfinite(value) else None


def quoted(line):
    """Fields of a row whose arm has a name in quotes, since it holds some or a comma."""
    end = line.rfind(b'",')
    return [line[1:end].replace(b'""', b'"'), *line[end + 2:].split(b",")]


class Arm:
    """An arm's history, and the rows that its next bin is made of."""

    def __init__(self, layout):
        self.layout = layout
        self.history = History(layout)
        self.counts = [0] * len(COUNTS)  # of all rows; counted[] of those in bins
        self.counted = [0] * len(COUNTS)
        self.rows = []      # innovation, NIS and states
        self.fields = None  # all of the last row
        self.slot = None    # of the bin, on the arm's clock
        self.t = -math.inf
        self.opened = self.heard = 0.0  # s, of the wall clock
        self.change = None  # the last event

    def take(self, fields, bin_s, capacity, now):
        """A row; ValueError or KeyError if it is none."""
        t = float(fields[self.layout.t])
        status = fields[self.layout.status]
        place = None if status == b"ok" else STATUS[status]
        try:
            numbers = tuple(map(float, self.layout.of_each_row(fields)))
        except ValueError:  # states that only other arms have are empty
            numbers = tuple(float(field or "nan") for field in self.layout.of_each_row(fields))
        if not math.isfinite(t):
            raise ValueError
        slot = t // bin_s
        if slot != self.slot or t <= self.t:
            self.close(capacity)
            if t <= self.t:
                self.history.forget_from(t)
            self.slot, self.opened = slot, now
        self.counts[0] += 1
        if place:
            self.counts[place] += 1
        self.rows.append(numbers)
        self.fields, self.t, self.heard = fields, t, now

    def close(self, capacity):
        """Makes the bin, as far as it has come."""
        if not self.rows:
            return
        layout, fields = self.layout, self.fields
        innovation, nis, *states = [[v for v in column if v == v] or [math.nan] for column in zip(*self.rows)]
        bin = array("d", [0, self.t, *(a - b for a, b in zip(self.counts, self.counted)), min(innovation),
                          max(innovation), number(fields[layout.innovation_sd]), sum(nis) / len(nis)])
        for value, column, sd in zip(self.rows[-1][2:], states, layout.sd_of_states):
            bin.extend((value, min(column), max(column), number(fields[sd])))
        bin.extend([number(fields[i]) for i in layout.of_parameters])
        self.history.append(bin, capacity)
        self.rows, self.counted, self.slot = [], self.counts[:], None

    def judged(self, name, silent_s):
        """Its line in the table of arms, by what its last seconds say."""
        at, bins = self.layout.at, self.history.recent(RECENT_S)
        total = {name: sum(bin[at[name]] for bin in bins) for name in COUNTS}
        peaks = (max(abs(bin[at["innovation_min"]]), abs(bin[at["innovation_max"]])) / bin[at["innovation_sd"]]
                 for bin in bins if bin[at["innovation_sd"]] > 0 and bin[at["nis"]] == bin[at["nis"]])
        return {"arm": name, "t": self.t, "nis": finite(self.layout.mean_nis(bins)),
                "peak": finite(max(peaks, default=math.nan)), "silent": silent_s if silent_s >= SILENT_S else None,
                "lost": 100 * (total["rejected"] + total["missing"]) / max(total["rows"], 1),
                "change": self.change}


def badness(judged):
    """Greatest of the worst: silent, without any measurement, or of the greatest mean NIS."""
    return (judged["silent"] is not None, math.inf if judged["nis"] is None else judged["nis"])


class Stream:
    """All arms of a stream. Without names in the stream there is one, called b""."""

    def __init__(self):
        self.layout = None
        self.arms = {}
        self.rows = self.malformed = self.lines = 0
        self.rest = b""  # the line that has not come to its end
        self.ended = False
        self.size_for(1)

    def size_for(self, arms):
        """Of many arms each has fewer and longer bins."""
        self.capacity = capacity_among(arms)
        self.bin_s = min(LONGEST_BIN_S, BIN_S * max(1, arms / MANY))

    def feed(self, chunk, now):
        """The next bytes, which may end anywhere; `now` in s, of a clock that is never set."""
        lines = (self.rest + chunk).split(b"\n")
        self.rest = lines.pop()
        for line in lines:
            self.lines += 1
            if not self.layout:
                self.begin(line)
                continue
            fields = line.split(b",") if line[:1] != b'"' else quoted(line)
            try:
                self.take(fields, now)
            except (ValueError, KeyError):
                self.malformed_or_header(line)
        if len(self.rest) > LONGEST_LINE:
            self.rest = b""
            self.malformed += 1

    def begin(self, header):
        if header.strip() and not header.startswith(b"#"):
            self.layout = Layout(header)

    def take(self, fields, now):
        if len(fields) != len(self.layout.names):
            raise ValueError
        key = fields[0] if self.layout.keyed else b""
        arm = self.arms.get(key)
        if arm:
            arm.take(fields, self.bin_s, self.capacity, now)
        else:
            arm = Arm(self.layout)
            arm.take(fields, self.bin_s, self.capacity, now)  # who is no arm does not get this far
            self.admit(key, arm)
        self.rows += 1

    def admit(self, key, arm):
        if len(self.arms) == MOST_ARMS:
            del self.arms[min(self.arms, key=lambda name: self.arms[name].heard)]
        self.arms[key] = arm
        self.size_for(len(self.arms))

    def malformed_or_header(self, line):
        """A filter that was resumed writes its header once more; another model has another one."""
        if not line.strip() or line.startswith(b"#"):
            return
        try:
            layout = Layout(line)
        except InputError:
            self.malformed += 1
            return
        if layout.names != self.layout.names:
            self.layout = layout
            self.arms.clear()

    def close_late(self, now):
        """Bins that have waited for long, of arms that send seldom or no more."""
        for arm in self.arms.values():
            if arm.rows and now - arm.opened >= LATE_S:
                arm.close(self.capacity)

    def end(self):
        self.ended = True
        for arm in self.arms.values():
            arm.close(self.capacity)

    def table(self, now):
        """Its arms, worst first."""
        judged = [arm.judged(shown_name(key), 0.0 if self.ended else now - arm.heard)
                  for key, arm in self.arms.items()]
        return sorted(judged, key=badness, reverse=True)


def shown_name(key):
    return key.decode("utf-8", "replace")


class Events:
    """Lines of JSON that `armukf estimate --watch --events FILE` writes."""

    def __init__(self):
        self.newest = deque(maxlen=MOST_EVENTS)
        self.count = self.malformed = 0
        self.rest = b""

    def feed(self, chunk):
        """The events that these bytes complete."""
        lines = (self.rest + chunk).split(b"\n")
        self.rest = lines.pop()[-LONGEST_LINE:]
        return [event for line in lines if line.strip() and (event := self.event(line))]

    def event(self, line):
        try:
            event = json.loads(line)
            float(event["t"])
            json.dumps(event, allow_nan=False)
        except (ValueError, KeyError, TypeError):
            self.malformed += 1
            return None
        self.newest.append(event)
        self.count += 1
        return event

    def since(self, cursor):
        new = min(self.count - cursor, len(self.newest))
        return list(self.newest)[len(self.newest) - new:]
