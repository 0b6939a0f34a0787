#!/usr/bin/python3
"""Prints the parameters of a recursive and of a batch estimate beside the truth that `armukf simulate`
uses by default.

    against_truth.py ESTIMATE.json FIT.json
"""

import json
import sys

from recursive_figures import TRUTH


def parameters(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)["parameters"]


def main():
    recursive, batch = (parameters(path) for path in sys.argv[1:3])
    print(f"{'':6}{'truth':>12}{'recursive':>14}{'± sd':>10}{'off by':>10}{'batch':>14}{'± sd':>10}"
          f"{'off by':>10}  unit")
    for name, truth in TRUTH.items():
        cells = "".join(
            f"{p['value']:14.6g}{p['sd']:10.2g}{100 * (p['value'] / truth - 1):8.3f} %"
            for p in (recursive[name], batch[name]))
        print(f"{name:6}{truth:12.6g}{cells}  {recursive[name]['unit']}")


if __name__ == "__main__":
    main()
