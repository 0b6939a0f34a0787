#!/usr/bin/python3
"""One self-contained HTML page of what `armukf diagnose` found.

    armukf diagnose RUN.csv --validate OTHER.csv --json found.json --rows found.csv
    report.py found.json found.csv -o report.html

In plain words what is missing, how sure that is, how much better the completed model does, and what to do next; then
charts to zoom into and to point at. Without the rows it has words and tables, but no charts. It needs no network, and
nothing runs in it but what it came with. uPlot, which draws, is Leon Sorokin's, under the MIT licence.
"""

import argparse
import sys
from pathlib import Path

import pages
import report_charts as charts
import report_tables as tables
import report_words as words
from inputs import InputError, read_json, read_table
from pages import Markup, element, escaped
from style import title_of

HERE = Path(__file__).resolve().parent
STYLES = ("live_page/uPlot.min.css", "live_page/colours.css", "report_page/report.css")
SCRIPTS = ("live_page/uPlot.iife.min.js", "live_page/drawing.js", "report_page/charts.js", "report_page/report.js")
LICENCE = "live_page/uPlot.LICENSE.txt"
COLUMNS = ["t", "y", "residual_before", "residual_after"]


class Page:
    """Sections, and the charts that their places are for."""

    def __init__(self):
        self.parts, self.charts = [], []

    def add(self, *parts):
        self.parts += parts

    def section(self, heading, *parts, about=""):
        told = (" ", element("small", about)) if about else ()
        self.add(element("section", element("h2", heading, *told), *parts))

    def place(self, chart, otherwise):
        """Where a chart goes, or why there is none."""
        if not chart or not chart["views"]:
            return tables.note(otherwise)
        self.charts.append(chart)
        return element("figure", id="chart-" + chart["id"])


def header(found):
    files = found["files"]
    return element("header", element("p", "armukf diagnose", class_="by"), element("h1", words.title(found)), element(
        "p", f"Fitted to {files['estimation']}, judged on {files['validation']}; {words.starts_text(found)}; "
             f"{found['seconds']:.1f} s.", class_="note"))


def with_code(text):
    """What stands between backticks is what one types."""
    return Markup("".join(element("code", part) if i % 2 else escaped(part) for i, part in enumerate(text.split("`"))))


def lead(found):
    answers = [element("p", element("b", question), " ", with_code(answer)) for question, answer in words.lead(found)]
    return element("section", *answers, id="lead")


def add_effects(page, found, judged):
    if not found["effects"]:
        return
    told = []
    for effect in found["effects"]:
        name = title_of(effect)
        chart = charts.shape_of(effect, judged, found.get("laws", {})) if judged else None
        why = "The rows hold no torque of it: it acts on what is measured." if judged else "There are no rows."
        told.append(element("article", element("h3", name), tables.effect_facts(effect), page.place(chart, why)))
    page.section("Effects found", *told)


def add_residual(page, judged):
    if judged is None:
        page.section("Residual", tables.note("There are no rows, so there are no charts; armukf diagnose --rows FILE "
                                             "writes them."))
        return
    residual, speed = charts.over_time(judged)
    page.section("Residual, before and after" if judged.completed else "Residual",
                 page.place(residual, ""), page.place(speed, ""), page.place(charts.spectrum(judged), ""),
                 tables.bands(charts.by_band(judged), judged.completed),
                 page.place(charts.by_speed(judged), "The speed never changes."),
                 page.place(charts.by_angle(judged), "The rows hold no motor_angle that changes."),
                 about="of the records that judge")


def body(found, rows):
    """The page's markup, and what its scripts draw."""
    judged = charts.Judged(rows) if rows is not None else None
    page = Page()
    page.add(header(found), lead(found))
    add_effects(page, found, judged)
    add_residual(page, judged)
    page.section("In numbers", tables.measures(found))
    page.section("Parameters", tables.parameters(found), tables.consistency(found))
    page.section("What is left", tables.left(found))
    page.section("Why these and no others" if found["effects"] else "Why none", tables.ranking(found["candidates"]),
                 about="what each candidate takes off the error of predictions, and why it was refused")
    page.add(element("noscript", "The charts are drawn with JavaScript, which is off here."))
    page.add(element("footer", "Drag over a chart to zoom, double-click to see all; pointing tells values. Times are "
                               "zoomed together."))
    content = {"columns": charts.shared_columns(judged) if judged else {}, "charts": page.charts}
    return Markup("<main>" + "\n".join(page.parts) + "</main>"), content


def text_of(name):
    return (HERE / name).read_text(encoding="utf-8")


def html_of(found, rows):
    markup, content = body(found, rows)
    style = "\n".join(map(text_of, STYLES))
    licensed = f"/*\n{text_of(LICENCE)}*/\n"
    scripts = [licensed + text_of(name) if "uPlot" in name else text_of(name) for name in SCRIPTS]
    return pages.drawn_page(f"{words.title(found)} – armukf diagnosis", markup, style, scripts, content)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("json", metavar="FOUND.json")
    parser.add_argument("rows", metavar="FOUND.csv", nargs="?")
    parser.add_argument("-o", "--output", required=True)
    options = parser.parse_args()
    for key in ("verdict", "effects", "before", "after", "candidates", "files"):
        read_json(options.json, key)
    text = html_of(read_json(options.json), read_table(options.rows, COLUMNS) if options.rows else None)
    try:
        Path(options.output).write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{options.output}: {error.strerror}") from None


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
