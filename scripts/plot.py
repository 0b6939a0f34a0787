#!/usr/bin/python3
"""Pictures of what armukf reads and writes, as PNG, SVG or PDF by the suffix of -o.

    plot.py records RECORD.csv...              torque and speed
    plot.py fit ROWS.csv...                    model against data, one below the other (start values,
                                               then estimate); rows of `armukf evaluate --rows`
    plot.py errors ROWS.csv...                 its errors, likewise
    plot.py response ROWS.csv                  frequency response of data, model and residual
    plot.py correlation EVALUATION.json        residual with itself and with the input, 99 % bands
    plot.py parameters ESTIMATE.csv            trajectories of the unknown parameters, 90 % bands,
            [--batch FIT.json] [--truth]       beside the batch values (JSON of `armukf fit`)
    plot.py laws FIT.json                      learnt laws (`armukf fit --effect friction_curve`),
                                               90 % bands
    plot.py events ESTIMATE.csv EVENTS.jsonl   what changed, and when, of `armukf estimate --watch
                                               --events EVENTS.jsonl`; trajectories, and NIS
    plot.py innovations ESTIMATE.csv           innovations within ±3 sd, and the running mean NIS
    plot.py nis ESTIMATE.csv                   NIS, averaged over 0.25 s, against chi-square bounds

ESTIMATE.csv is what `armukf estimate` prints. --truth draws the values that `armukf simulate` uses.
"""

import argparse
import sys
from pathlib import Path

import pictures
from events import events_in
from inputs import InputError, read_json, read_table
from pictures import plt

ROWS = ["t", "u", "y", "y_hat", "residual"]
ESTIMATE = ["t", "innovation", "innovation_sd", "nis"]


def read_events(path):
    try:
        return events_in(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{path}: holds no events; is it what armukf wrote?") from None


def picture(options):
    first, names = options.files[0], [Path(file).stem for file in options.files]
    several = {"records": (pictures.records, ["t", "u", "y"]), "fit": (pictures.fit, ROWS),
               "errors": (pictures.errors, ROWS)}
    if options.picture in several:
        draw, columns = several[options.picture]
        return draw([read_table(file, columns) for file in options.files], names)
    if options.picture == "events":
        if len(options.files) != 2:
            raise InputError("events takes two files, ESTIMATE.csv and EVENTS.jsonl")
        return pictures.events(read_table(first, ESTIMATE), read_events(options.files[1]))
    if len(options.files) > 1:
        raise InputError(f"{options.files[1]}: {options.picture} takes one file")
    if options.picture == "response":
        return pictures.response(read_table(first, ROWS), names[0])
    if options.picture == "correlation":
        return pictures.correlation(read_json(first, "experiments", 0, "residual"), names[0])
    if options.picture == "laws":
        return pictures.laws(read_json(first, "laws"))
    rows = read_table(first, ESTIMATE)
    if options.picture == "parameters":
        batch = read_json(options.batch, "parameters") if options.batch else None
        return pictures.parameters(rows, options.truth, batch)
    return getattr(pictures, options.picture)(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("picture", choices=["records", "fit", "errors", "response", "correlation",
                                            "parameters", "laws", "events", "innovations", "nis"])
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--batch", metavar="FIT.json")
    parser.add_argument("--truth", action="store_true")
    options = parser.parse_args()
    if Path(options.output).suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"{options.output}: the suffix must be .png, .svg or .pdf")
    figure = picture(options)
    figure.tight_layout()
    plt.rcParams["svg.hashsalt"] = "armukf"  # the same picture is the same file
    metadata = {"Date": None} if options.output.endswith(".svg") else None
    try:
        figure.savefig(options.output, dpi=130, metadata=metadata)
    except OSError as error:
        raise InputError(f"{options.output}: {error.strerror}") from None


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
