"""What is remembered of an arm: bins of its rows, old ones merged to coarser ones.

A bin covers 20 ms of the arm's own time. It tells how many rows it had and how many of them were missing,
rejected, gaps and resets; their least and largest innovation and mean NIS; the least and largest value of
each state; and of sd, states and parameters what the last row says. Extremes are taken over every row, so that
an outlier of a single sample is seen however far one looks back.

Where a level has more than CAPACITY bins, its four oldest become one of the next level, four times as long.
So what is kept grows as the logarithm of time: 20 s at 20 ms, the 80 s before at 80 ms, ..., a year in 12
levels: 12,000 bins, 5 MB for five states and seven parameters. Of more than MANY arms each keeps fewer.
"""

from collections import deque
from itertools import islice

MERGED = 4       # bins into one of the next level
CAPACITY = 1000  # bins of a level: about one per pixel
FEWEST = 50      # of them, with many arms
MANY = 20        # arms that get all of that


def capacity_among(arms):
    """Bins of a level that each of so many arms has."""
    return max(FEWEST, CAPACITY * MANY // max(arms, MANY))


class History:
    """An arm's bins, the newest at level 0, and a journal: who has all up to `written` needs only what is new.

    Who follows the journal appends each bin to its level and, for one above level 0, drops the four oldest
    of the level below."""

    def __init__(self, layout):
        self.layout = layout
        self.levels = [deque()]
        self.journal = deque(maxlen=CAPACITY)
        self.written = 0

    def append(self, bin, capacity, level=0):
        if level == len(self.levels):
            self.levels.append(deque())
        bin[0] = level
        self.levels[level].append(bin)
        self.journal.append(bin)
        self.written += 1
        while len(self.levels[level]) > capacity:
            oldest = [self.levels[level].popleft() for _ in range(MERGED)]
            self.append(self.layout.merged(oldest), capacity, level + 1)

    def forget_from(self, t):
        """Rows from t on come again: a filter was resumed, or a clock was set."""
        for level in self.levels:
            while level and level[-1][1] >= t:
                level.pop()
        self.journal.clear()
        self.written += 1  # the journal leads from nowhere to here: who follows it gets everything anew

    def all(self):
        """Oldest first."""
        return [bin for level in reversed(self.levels) for bin in level]

    def since(self, cursor):
        """Bins that came after the cursor, and whether they are instead all that there are."""
        new = self.written - cursor
        if 0 <= new <= len(self.journal):
            return list(islice(self.journal, len(self.journal) - new, None)), False
        return self.all(), True

    def recent(self, seconds):
        """The newest bins, newest first."""
        found = []
        for bin in reversed(self.levels[0]):
            if bin[1] < self.levels[0][-1][1] - seconds:
                break
            found.append(bin)
        return found
