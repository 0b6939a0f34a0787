#!/usr/bin/python3
"""Prints the parameters of an estimate's JSON beside those that `armukf simulate` uses by default."""

import json
import sys

from recursive_figures import TRUTH


def main():
    parameters = json.load(open(sys.argv[1], encoding="utf-8"))["parameters"]
    print(f"{'parameter':10} {'estimate':>12} {'sd':>10} {'truth':>12} {'off by':>10}  in 90 % interval")
    for name, truth in TRUTH.items():
        value, sd = parameters[name]["value"], parameters[name]["sd"]
        inside = "yes" if abs(value - truth) < 1.645 * sd else "no"
        print(f"{name:10} {value:12.6g} {sd:10.2g} {truth:12.6g} {100 * (value / truth - 1):8.3f} %  {inside}")


if __name__ == "__main__":
    main()
