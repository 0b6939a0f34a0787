"""The parts of a diagnosis' page that are text and tables."""

from pages import Markup, element, escaped
from report_words import PLAIN, figure, unit_text, with_deviation
from style import NINETY_PERCENT, title_of

MEASURES = {"fit_percent": "simulation fit, %", "mse": "simulation MSE, (rad/s)²",
            "one_step_rmse": "one step ahead, RMSE, rad/s",
            "log_likelihood": "log-likelihood of the innovations",
            "ljung_box_p": "whiteness of the innovations, Ljung-Box p"}
FREE_MEASURES = ("fit_percent", "mse")  # that a model with effects of the motor's angle has twice
ONLY_BEGUN = "lowers the error of predictions less than others, or hardly at all"
WIDTH, HEIGHT, MARGIN = 220.0, 26.0, 8.0  # of a picture of two estimates
CHANCE = 0.001  # for all comparisons of parts of the data together


def cell(content, **attributes):
    return element("td", content, **attributes)


def number(value, digits=6, **attributes):
    return cell(figure(value, digits), **{"class_": "number", **attributes})


def table(head, lines, id_=None):
    """Heads of columns of numbers begin with #."""
    heads = Markup("".join(element("th", h.removeprefix("#"), class_="number" if h.startswith("#") else None)
                           for h in head))
    return element("div", element("table", element("thead", element("tr", heads)),
                                  element("tbody", *(element("tr", *line) for line in lines))), class_="scroll", id=id_)


def note(text):
    return element("p", text, class_="note")


def measures(found):
    lines = []
    for record in ("validation", "estimation"):
        before, after = (found[when][record] for when in ("before", "after"))
        over = ", over the measured angle" if after.get("over_measured_angle") else ""
        told = [(label + over * (key in FREE_MEASURES), before[key], after[key]) for key, label in MEASURES.items()]
        if over:
            told += [(f"free {MEASURES[key]}", before["free"][key], after["free"][key]) for key in FREE_MEASURES]
        role = "judges" if record == "validation" else "was fitted"
        lines.append((element("th", found["files"][record] + " ", element("small", role), colspan=3, class_="group"),))
        lines += [(cell(label), *(number(v) for v in both[-sides(found):])) for label, *both in told]
    return table(("", "#before", "#after") if found["effects"] else ("", "#the model"), lines, id_="measures")


def sides(found):
    """Before and after, or the one model that is both."""
    return 2 if found["effects"] else 1


def effect_facts(effect):
    plain = PLAIN.get(effect["name"].partition(":")[0], "")
    values = [element("li", element("b", name), " ", with_deviation(p["value"], p["sd"], p["unit"]),
                      "" if not p.get("known") else " (known)") for name, p in effect["parameters"].items()]
    parts = [element("p", plain[:1].upper() + plain[1:] + "." if plain else ""), element("ul", *values),
             element("p", f"When it was added, the validation error fell by {effect['mse_reduction_percent']:.3g} %; "
                          f"p {figure(effect['p_value'], 2)}, counting all that was tried.")]
    if effect["confused_with"]:
        apart = ", or ".join(effect.get("told_apart_by", []))
        parts.append(element("p", f"Not told apart from {', '.join(effect['confused_with'])}"
                             + (f"; {apart} would." if apart else "."), class_="warning"))
    return element("div", *parts, class_="facts")


def bar(value, most, kind):
    """A length for a share, that may be negative."""
    share = 0.0 if not most else min(max(value / most, 0.0), 1.0)
    return Markup(f'<svg class="bar" viewBox="0 0 100 8" preserveAspectRatio="none" aria-hidden="true"><rect '
                  f'class="{kind}" width="{100 * share:.2f}" height="8"/></svg>')


def begun(candidate):
    """Whether a candidate was left when others did better, before it was judged."""
    return not candidate["accepted"] and candidate.get("refused_because") == ONLY_BEGUN


def candidate_row(c, most):
    why = element("b", "accepted") if c["accepted"] else escaped(c.get("refused_because", "no reason was told"))
    length = bar(c["help_percent"], most, "after" if c["accepted"] else "measured")
    return (cell(title_of(c), class_="name"), cell(length, class_="bars"),
            cell(f"{c['help_percent']:.2f}", class_="number"), number(c["statistic"], 3, class_="number fine"),
            number(c["p_value"], 2, class_="number fine"), cell(why, class_="why"))


def ranking(candidates):
    """A table for each round, what was accepted first, then by help."""
    most = max((c["help_percent"] for c in candidates), default=0.0)
    parts = []
    for round_ in sorted({c["round"] for c in candidates}):
        own = [c for c in candidates if c["round"] == round_]
        judged = sorted((c for c in own if not begun(c)), key=lambda c: (not c["accepted"], -c["help_percent"]))
        lines = [candidate_row(c, most) for c in judged]
        if rest := [title_of(c) for c in own if begun(c)]:
            lines.append((cell(", ".join(rest), colspan=5, class_="several"), cell(ONLY_BEGUN, class_="why")))
        accepted = next((title_of(c) for c in own if c["accepted"]), None)
        told = f"found: {accepted}" if accepted else "nothing found"
        shown = table(("candidate", "", "#error less by, %", "#statistic", "#p", "why"), lines)
        parts.append(element("details", element("summary", f"Round {round_} ", element("small", told)), shown,
                             class_="round", open="" if accepted or round_ == 1 else None))
    return Markup("".join(parts))


def whisker(scale, value, sd, when, y):
    low, high = scale(value - NINETY_PERCENT * (sd or 0.0)), scale(value + NINETY_PERCENT * (sd or 0.0))
    return (f'<g class="{when}"><line x1="{low:.1f}" x2="{high:.1f}" y1="{y}" y2="{y}"/>'
            f'<circle cx="{scale(value):.1f}" cy="{y}" r="3"/></g>')


def interval_picture(p):
    """Both estimates with their 90 % bands, on one scale."""
    told = [(when, p[when], p[f"{when}_sd"], y) for when, y in (("before", 8), ("after", 18)) if p[when] is not None]
    ends = [value + sign * NINETY_PERCENT * (sd or 0.0) for _, value, sd, _ in told for sign in (-1, 1)]
    low, span = min(ends), max(ends) - min(ends)

    def scale(x):
        return MARGIN + (WIDTH - 2 * MARGIN) * ((x - low) / span if span else 0.5)
    drawn = "".join(whisker(scale, value, sd, when, y) for when, value, sd, y in told)
    return Markup(f'<svg class="interval" viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" aria-hidden="true">{drawn}</svg>')


def change_text(p):
    """How far a parameter has moved."""
    if p["before"] is None:
        return "new"
    if p["before_sd"] is None:
        return "was known"
    if not p["before"]:
        return ""
    percent = 100 * (p["after"] / p["before"] - 1)
    return f"{percent:+.2g} %" if abs(percent) < 99.5 else f"{percent:+.0f} %"


def estimate_text(p, when):
    if p[when] is None:
        return "–"
    return with_deviation(p[when], p[f"{when}_sd"])


def name_and_unit(name, p):
    return cell(name, class_="name"), cell(unit_text(p["unit"]))


def parameters(found):
    if "parameters" not in found:
        return note("The JSON holds no parameters before and after: an older armukf has written it.")
    told = found["parameters"].items()
    if not found["effects"]:
        return table(("parameter", "unit", "#value"), [
            (*name_and_unit(name, p), cell(estimate_text(p, "after"), class_="number")) for name, p in told],
            id_="parameters")
    lines = [(*name_and_unit(name, p), cell(estimate_text(p, "before"), class_="number"),
              cell(estimate_text(p, "after"), class_="number"), cell(change_text(p), class_="number"),
              cell(interval_picture(p), class_="intervals")) for name, p in told]
    return table(("parameter", "unit", "#before", "#after", "#change", "90 % bands"), lines, id_="parameters")


def consistency(found):
    told = found.get("consistency", [])
    if not told:
        return note("The JSON does not say whether parts of the data agree.")
    apart = [c for c in told if c["p_value"] is not None and c["p_value"] * len(told) <= CHANCE]
    summary = "agree within their deviations" if not apart else \
        f"disagree on {', '.join(dict.fromkeys(c['parameter'] for c in apart))}"
    lines = [(cell(c["parameter"], class_="name"), cell(c["between"]),
              *(cell(with_deviation(v, s), class_="number") if v is not None else cell("–")
                for v, s in zip(c["values"], c["sd"])),
              cell(figure(c["p_value"], 2), class_="number warning" if c in apart else "number")) for c in told]
    return element("details", element("summary", f"Parts of the data {summary}"), table(
        ("parameter", "between", "#one", "#other", "#p"), lines))


def bands(told, completed):
    """told: (from Hz, to Hz, rms before, after)"""
    sides = slice(0 if completed else 1, 2)
    most = max((rms for *_, before, after in told for rms in (before, after)), default=0.0)
    lines = [(cell(f"{low:g} – {high:g} Hz", class_="name"), *[number(rms, 3) for rms in both[sides]],
              cell(Markup("".join([bar(rms, most, kind) for rms, kind in zip(both, ("before", "after"))][sides])),
                   class_="bars")) for low, high, *both in told]
    heads = ("band", "#before, rad/s rms", "#after, rad/s rms", "") if completed else ("band", "#rad/s rms", "")
    return table(heads, lines, id_="bands")


def left(found):
    if not found["unexplained"]:
        return element("p", "Nothing that stands out of the noise.")
    return element("ul", *(element("li", text) for text in found["unexplained"]))

