#!/usr/bin/python3
"""Finds noise, prior and annealing of the filter by maximum likelihood, and shows what that changes.

    tune.py RECORD... [--validate RECORD...] [--model FILE.toml] [--tune NAME...] [--save TUNED.toml]

The likelihood is that of the innovations on the training records: the first part (--train) of each
RECORD, or all of them where --validate names others. The rest judges. Positive quantities are sought in
log coordinates by the simplex method of Nelder and Mead from several starts, the first of which is
--model or the defaults. Measurements that the filter rejects count as if they lay on its gate.
--keep-fit P: parameters whose simulation fits the training records worse by more than P percent points
than before are refused: on records that hold what the model lacks, likelihood alone would give up the
parameters to explain it by noise.
"""

import argparse
import copy
import csv
import math
import random
import tempfile
import tomllib
from pathlib import Path

import sweeps
from sweeps import Trouble, armukf

# Bounds of what can be tuned, and where the search begins if it is 0 in the model.
BOUNDS = {
    "noise.sensor": (1e-4, 100.0, 0.1), "noise.motor_torque": (1e-6, 10.0, 3e-3),
    "noise.gear_torque": (1e-6, 10.0, 3e-3), "noise.arm_torque": (1e-6, 10.0, 1e-3),
    "noise.model_error.start": (1e-2, 1e3, 16.0), "noise.model_error.least": (1e-4, 1e2, 1e-2),
    "noise.model_error.gain": (1e-4, 100.0, 1.0), "noise.model_error.time_s": (1e-3, 100.0, 0.3),
    "noise.parameter_walk.start": (1e-4, 10.0, 0.35), "noise.parameter_walk.floor": (1e-6, 1.0, 2e-3),
    "noise.parameter_walk.time_s": (1e-2, 100.0, 1.0),
    "prior.twist": (1e-4, 10.0, 0.3), "prior.speed": (1e-3, 100.0, 5.0)}
DEFAULT = ["noise.sensor", "noise.motor_torque", "noise.gear_torque", "noise.model_error.gain",
           "noise.parameter_walk.start", "noise.parameter_walk.floor", "prior.twist"]
ROUND = 60         # evaluations between two savings of the state
AGREE = 2e-3       # per sample: starts whose likelihood is that near have found the same
REFUSED = 1e6      # instead of an infinite objective, over which no simplex can be ordered
BUILT_IN = {"noise": {"sensor": 0.1, "motor_torque": 0.003, "gear_torque": 0.003, "arm_torque": 0.0,
                      "model_error": {"start": 16.0, "least": 0.0, "gain": 4.0, "time_s": 0.3},
                      "parameter_walk": {"start": 0.35, "floor": 0.002, "time_s": 1.0},
                      "learning": {"most_torque": 0.1}},
            "prior": {"twist": 0.3, "speed": 5.0}}


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml_value(v)}" for k, v in value.items()) + " }" if value else "{}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(value)


def toml_text(content):
    """A model file: values at the top, then a section per table."""
    lines = [f"{k} = {toml_value(v)}" for k, v in content.items() if not isinstance(v, dict)]
    for name, section in content.items():
        if isinstance(section, dict):
            lines += ["", f"[{name}]"] + [f"{k} = {toml_value(v)}" for k, v in section.items()]
    return "\n".join(lines).lstrip("\n") + "\n"


def looked_up(content, name):
    for key in name.split("."):
        content = content[key]
    return float(content)


def with_values(content, values):
    """The model file's content with these settings."""
    content = copy.deepcopy(content)
    for name, value in values.items():
        *path, last = name.split(".")
        table = content
        default = BUILT_IN
        for key in path:
            default = default[key]
            if key not in table:
                table[key] = copy.deepcopy(default) if key in ("model_error", "parameter_walk") else {}
            table = table[key]
        table[last] = value
    return content


def start_value(content, name):
    try:
        value = looked_up(content, name)
    except KeyError:
        value = looked_up(BUILT_IN, name)
        if name.endswith("_torque"):  # what is usual of torques goes with the arm's inertia
            value *= content.get("parameters", {}).get("J", {}).get("value", sweeps.INERTIA) / sweeps.INERTIA
    return value if value > 0 else BOUNDS[name][2]


def passes(job, values):
    """One filter pass over each training record: the scores, and the simulation fits if they count."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder, "model.toml")
        model.write_text(toml_text(with_values(job["content"], values)))
        common = ["--model", model, *(["--filter", job["filter"]] if job["filter"] else [])]
        scores = [armukf(job["program"], "estimate", r, *common, "--score") for r in job["records"]]
        fits = [armukf(job["program"], "estimate", r, *common)["simulation"]["fit_percent"]
                for r in job["records"]] if job["keep_fit"] is not None else []
    return scores, fits


def objective(job, coordinates):
    """Minus the log-likelihood per measurement, plus what a worse simulation costs."""
    try:
        scores, fits = passes(job, dict(zip(job["names"], map(math.exp, coordinates))))
    except Trouble:
        return REFUSED
    parts = [part for score in scores for part in score["parts"]]
    count = sum(part["measurements"] for part in parts)
    value = -sum(part["log_likelihood"] or -math.inf for part in parts) / max(count, 1)
    for fit, least in zip(fits, job["least_fits"]):
        value += 10.0 * max(0.0, least - (fit if fit is not None else -REFUSED))
    return value if math.isfinite(value) else REFUSED


def simplex_round(job):
    """Goes on from the simplex for some evaluations."""
    from scipy.optimize import minimize
    bounds = [tuple(map(math.log, BOUNDS[name][:2])) for name in job["names"]]
    found = minimize(lambda z: objective(job, z), job["simplex"][0], method="Nelder-Mead", bounds=bounds,
                     options={"initial_simplex": job["simplex"], "maxfev": ROUND + len(job["names"]) + 1,
                              "xatol": 3e-3, "fatol": 1e-5, "adaptive": True})
    simplex, values = found.final_simplex
    return {"simplex": simplex.tolist(), "value": float(values[0]), "evaluations": int(found.nfev),
            "converged": bool(found.success)}


def first_simplex(names, centre, size=1.0):
    inside = [min(max(z, math.log(BOUNDS[n][0]) + 2 * size), math.log(BOUNDS[n][1]) - 2 * size)
              for n, z in zip(names, centre)]
    return [inside] + [[z + size * (i == k) for i, z in enumerate(inside)] for k in range(len(inside))]


def searched(pool, job, starts, rounds, ledger):
    """Every start until it converges; the best, and the values of all."""
    states = [{"simplex": first_simplex(job["names"], s), "value": math.inf, "evaluations": 0,
               "converged": False} for s in starts]
    for number in range(rounds):
        open_ = [i for i, state in enumerate(states) if not state["converged"]]
        if not open_:
            break
        jobs = [{**job, "simplex": states[i]["simplex"]} for i in open_]
        results = pool.map(simplex_round, jobs, ledger, f"round {number + 1} of at most {rounds}")
        for i, result in zip(open_, results):
            states[i] = {**result, "evaluations": states[i]["evaluations"] + result["evaluations"]}
    best = min(states, key=lambda state: state["value"])
    if best["value"] >= REFUSED:
        raise Trouble("no finite likelihood anywhere: the filter fails on these records whatever the noise")
    return best, states


def split(record, share, folder, number):
    """The first part of a record as a file of its own, and the time at which the rest begins."""
    try:
        lines = Path(record).read_text().splitlines()
    except OSError as error:
        raise Trouble(f"{record}: {error.strerror}") from error
    rows = [line for line in lines if line and not line.startswith("#")]
    first = 1 + int(share * (len(rows) - 1))
    if first < 3 or first >= len(rows):
        raise Trouble(f"{record}: too short to keep a part for validation")
    path = Path(folder, f"training_{number}.csv")
    path.write_text("\n".join(rows[:first]) + "\n")
    dialect = csv.Sniffer().sniff(rows[0], delimiters=",;\t")
    header = next(csv.reader(rows[:1], dialect))
    time = header.index("t") if "t" in header else 0
    return path, float(next(csv.reader([rows[first]], dialect))[time])


def judged(options, content, values, cuts):
    """Scores and simulation fits on training and validation."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder, "model.toml")
        model.write_text(toml_text(with_values(content, values)))
        common = ["--model", model, *(["--filter", options.filter] if options.filter else [])]
        training, validation, fits = [], [], []
        for record, cut in cuts:
            words = ["--score-cuts", repr(cut)] if cut is not None else []
            parts = armukf(options.program, "estimate", record, *common, "--score", *words)["parts"]
            training.append(parts[0])
            validation += parts[1:]
            result = armukf(options.program, "estimate", record, *common)
            if not sweeps.physical(result):
                raise Trouble(f"{record}: the parameters are not physical")
            fits.append(result["simulation"]["fit_percent"])
        for record in options.validate or []:
            validation += armukf(options.program, "estimate", record, *common, "--score")["parts"]
    return {"training": combined(training), "validation": combined(validation),
            "simulation_fit_percent": sum(fits) / len(fits)}


def combined(parts):
    count = sum(p["measurements"] for p in parts)

    def mean(value):
        return sum(value(p) * p["measurements"] for p in parts) / count
    return {"measurements": count, "rejected": sum(p["rejected"] for p in parts),
            "log_likelihood_per_sample": mean(lambda p: p["log_likelihood_per_sample"]),
            "mean_nis": mean(lambda p: p["innovation"]["mean_nis"]),
            "rmse": math.sqrt(mean(lambda p: p["innovation"]["rmse"] ** 2)),
            "ljung_box_p": min(p["innovation"]["ljung_box_p"] for p in parts)}


def at_bound(name, value):
    lower, upper, _ = BOUNDS[name]
    return value < 1.05 * lower or value > upper / 1.05


def text_of(result):
    lines = [f"{'':28} {'before':>12} {'tuned':>12}"]
    for name, entry in result["tuned"].items():
        note = "  at its bound: the records do not determine it" if entry["at_bound"] else ""
        lines.append(f"{name:28} {entry['before']:12.5g} {entry['value']:12.5g}{note}")
    for part in ("training", "validation"):
        lines.append(f"{part}")
        for key, unit in (("log_likelihood_per_sample", ""), ("mean_nis", ""), ("rmse", " rad/s"),
                          ("ljung_box_p", ""), ("rejected", "")):
            before, after = result["before"][part][key], result["after"][part][key]
            lines.append(f"  {key:26} {before:12.4g} {after:12.4g}{unit}")
    before, after = (result[k]["simulation_fit_percent"] for k in ("before", "after"))
    lines.append(f"{'simulation fit':28} {before:12.2f} {after:12.2f} %")
    lines.append(f"{result['starts_that_agree']} of {result['starts']} starts agree, "
                 f"{result['evaluations']} evaluations"
                 + ("" if result["converged"] else "; not converged: raise --rounds"))
    return "\n".join(lines)


def options_of(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="+", metavar="RECORD")
    parser.add_argument("--validate", nargs="+", metavar="RECORD")
    parser.add_argument("--train", type=float, default=0.7, help="share of each RECORD that is fitted, "
                        "without --validate")
    parser.add_argument("--model", metavar="FILE.toml")
    parser.add_argument("--filter", help="by default that of the model")
    parser.add_argument("--tune", nargs="+", metavar="NAME", default=DEFAULT, help="of "
                        + ", ".join(BOUNDS))
    parser.add_argument("--keep-fit", type=float, metavar="P")
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--rounds", type=int, default=12, help=f"of {ROUND} evaluations per start, at most")
    parser.add_argument("--seed", type=int, default=1, help="of the starts but the first")
    parser.add_argument("--save", metavar="FILE.toml")
    sweeps.add_options(parser)
    options = parser.parse_args(arguments)
    for name in options.tune:
        if name not in BOUNDS:
            raise Trouble(f"--tune: unknown '{name}'; known are: {', '.join(BOUNDS)}")
    if not 0.1 <= options.train <= 0.95:
        raise Trouble("--train: must be from 0.1 to 0.95")
    return options


def read_model(path):
    if path is None:
        return {}
    try:
        return tomllib.loads(Path(path).read_text())
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise Trouble(f"{path}: {error}") from error


def known_noise(sensor, motor_torque):
    """Settings of a filter that knows the noise, and its model to be complete."""
    return with_values(read_model(sweeps.ROOT / "data/known_noise.toml"),
                       {"noise.sensor": sensor, "noise.motor_torque": motor_torque})


def tuned(options, pool):
    # What is tuned here must not be learnt on the way, nor by who takes the tuned file.
    content = with_values(read_model(options.model), {"noise.learning.most_torque": 0.0})
    with tempfile.TemporaryDirectory() as folder:
        # A scheduler's workers may be elsewhere: what they read lies beside the state, if there is one.
        place = Path(options.state).resolve().parent if options.state else Path(folder)
        if options.validate:
            training, cuts = [Path(r).resolve() for r in options.records], [(r, None) for r in options.records]
        else:
            split_records = [split(r, options.train, place, k) for k, r in enumerate(options.records)]
            training = [path for path, _ in split_records]
            cuts = [(r, cut) for r, (_, cut) in zip(options.records, split_records)]
        job = {"program": str(Path(options.program).resolve()), "content": content, "names": options.tune,
               "filter": options.filter, "records": [str(r) for r in training],
               "keep_fit": options.keep_fit, "least_fits": []}
        if options.keep_fit is not None:
            job["least_fits"] = [fit - options.keep_fit for fit in passes(job, {})[1]]
        centre = [math.log(start_value(content, name)) for name in options.tune]
        draw = random.Random(options.seed)
        starts = [centre] + [[z + draw.gauss(0, 1.5) for z in centre] for _ in range(options.starts - 1)]
        best, states = searched(pool, job, starts, options.rounds, sweeps.Ledger(options.state))
        values = {n: math.exp(z) for n, z in zip(options.tune, best["simplex"][0])}
        result = {
            "tuned": {n: {"before": start_value(content, n), "value": v, "at_bound": at_bound(n, v)}
                      for n, v in values.items()},
            "before": judged(options, content, {}, cuts), "after": judged(options, content, values, cuts),
            "starts": len(states), "starts_that_agree": sum(s["value"] < best["value"] + AGREE for s in states),
            "evaluations": sum(s["evaluations"] for s in states), "converged": best["converged"]}
    if options.save:
        unfinished = Path(f"{options.save}.tmp")
        unfinished.write_text("# Settings tuned by scripts/tune.py.\n\n" + toml_text(with_values(content, values)))
        unfinished.replace(options.save)
    return result


def main():
    options = options_of()
    with sweeps.pool(options.workers, options.scheduler) as pool:
        result = tuned(options, pool)
    if options.json != "-":
        print(text_of(result))
    sweeps.write_json(options.json, result)


if __name__ == "__main__":
    sweeps.run_script(main)
