"use strict";

// The bins that the server keeps of an arm, kept here by the same rule: a bin of level k > 0 stands for the four
// oldest of the level below. So a page that is open for a year holds no more than the server: 12,000 bins.

const MERGED = 4;

class History {
  constructor(layout) {
    this.layout = layout;
    this.at = Object.fromEntries(layout.fields.map((name, i) => [name, i]));
    this.levels = [];
  }

  // A message: whether it is all that there is, then bins of layout.fields.length doubles each.
  take(numbers) {
    const anew = numbers[0] === 1, width = this.layout.fields.length;
    if (anew) this.levels = [];
    for (let begin = 1; begin < numbers.length; begin += width) {
      const bin = numbers.slice(begin, begin + width), level = bin[0];
      while (this.levels.length <= level) this.levels.push([]);
      this.levels[level].push(bin);
      if (level > 0 && !anew) this.levels[level - 1].splice(0, MERGED);
    }
  }

  // Oldest first; no bin is ever changed, so that what is shown while paused stays.
  all() {
    return this.levels.slice().reverse().flat();
  }
}

// Those of the bins that show in this stretch of time, and one beyond each end.
function within(bins, from, to) {
  const first = firstAfter(bins, from), end = firstAfter(bins, to);
  return bins.slice(Math.max(first - 1, 0), end + 1);
}

function firstAfter(bins, t) {
  let low = 0, high = bins.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (bins[middle][1] < t) low = middle + 1;
    else high = middle;
  }
  return low;
}
