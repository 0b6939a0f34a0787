"""The page of a fleet: what was found, worst first, and a row of trends for each arm."""

from datetime import timedelta
from statistics import median

import pages
from findings import by_arm, day, days, figure, series_of, without_strays
from pages import Markup, escaped, table
from style import BAND, ESTIMATE, NINETY_PERCENT, TRUE
from trends import rate_of

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 220.0, 96.0, 40.0, 8.0, 6.0, 16.0  # of a panel, and its margins
MONTH = 30.0  # days
STYLE = f"""body{{max-width:76em}}
.trends{{display:grid;grid-template-columns:repeat(auto-fill,minmax(13em,1fr));gap:.6em 1em;align-items:end}}
.trends p{{margin:0;font-size:13px;line-height:1.35}}svg{{width:100%;height:auto;display:block}}
h3{{margin:1.6em 0 .3em;border-top:1px solid #ccc;padding-top:.6em;overflow-wrap:anywhere}}
h3 small{{font-weight:normal;color:#555}}td{{vertical-align:top;white-space:nowrap}}
td:last-child{{white-space:normal;overflow-wrap:anywhere;min-width:6em}}
text{{font:9px sans-serif;fill:#555}}.band{{fill:{BAND}}}.value{{fill:none;stroke:{ESTIMATE};stroke-width:1.4}}
.point{{fill:{ESTIMATE}}}.stray{{fill:#fff;stroke:{ESTIMATE}}}
.mark{{stroke:{TRUE};stroke-width:1.2;stroke-dasharray:3 2}}.frame{{fill:none;stroke:#ccc}}"""


def sure_text(sure):
    if sure is None:
        return ""
    return "> 99.9 %" if sure > 0.999 else f"{100 * sure:.1f} %"


def change_text(f):
    if f.end is None:
        return ""
    percent = "" if f.percent is None else f" ({f.percent:+.3g} %)"
    return f"{figure(f.start, 4)} → {figure(f.end, 4)} ± {figure(f.sd, 2)} {f.unit}{percent}"


def since_text(f):
    return day(f.since) + ("" if f.t is None else f", at {f.t:.2f} s")


def found_table(findings, anchors):
    return table(("arm", "what", "how", "since", "from → to", "sure", "deviations", "records", "note"), (
        (Markup(f'<a href="#{anchors[f.arm]}">{escaped(f.arm)}</a>'), f.what, f.how, since_text(f), change_text(f),
         sure_text(f.sure), f"{f.size:.1f}" if f.size else "", f.records, f.note) for f in findings))


def rate_text(points):
    """How much it changes in a month, of what it usually is."""
    dates, values, sds, _ = zip(*points)
    rate, usual = rate_of(days(dates), values, sds), abs(median(values))
    if rate is None or not usual:
        return ""
    return Markup("<br>") + "{:+.2g} ± {:.1g} % in 30 days".format(*(100 * MONTH * r / usual for r in rate))


def corners(xs, ys):
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(xs, ys))


class Frame:
    """Where dates and values lie in a panel."""

    def __init__(self, points, span):
        halves = [NINETY_PERCENT * sd for _, _, sd, _ in points]
        # A record that tells nothing must not hide the others.
        shown = [(p[1], half) for p, half in zip(points, halves) if half <= 3 * median(halves)]
        self.low, self.high = min(value - half for value, half in shown), max(value + half for value, half in shown)
        self.first, self.length = span[0], span[1] - span[0]

    def x(self, date):
        share = (date - self.first) / self.length if self.length else 0.5
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def y(self, value):
        share = (self.high - value) / (self.high - self.low)
        return TOP + min(max(share, 0.0), 1.0) * (HEIGHT - TOP - BOTTOM)

    def band(self, points):
        xs = [self.x(p[0]) for p in points]
        upper, lower = ([self.y(p[1] + sign * NINETY_PERCENT * p[2]) for p in points] for sign in (1, -1))
        if len(points) == 1:  # a band needs a width
            xs, upper, lower = [xs[0] - 3, xs[0] + 3], 2 * upper, 2 * lower
        return corners(xs + xs[::-1], upper + lower[::-1])


def panel(name, points, span, marks):
    """One parameter over date, with its 90 % band; dashed: since when it is another; hollow: stands alone."""
    usual = without_strays(points)
    frame = Frame(usual, span)
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    value = corners([frame.x(p[0]) for p in usual], [frame.y(p[1]) for p in usual])
    lines = "".join(f'<line class="mark" x1="{frame.x(m):.1f}" x2="{frame.x(m):.1f}" y1="{TOP}" y2="{bottom}"/>'
                    for m in marks)
    dots = "".join(f'<circle class="{"point" if p in usual else "stray"}" cx="{frame.x(p[0]):.1f}" '
                   f'cy="{frame.y(p[1]):.1f}" r="2"/>' for p in points)
    texts = [(LEFT - 3, TOP + 7, "end", figure(frame.high, 3)), (LEFT - 3, bottom, "end", figure(frame.low, 3)),
             (LEFT, HEIGHT - 4, "start", day(span[0])[:10]), (right, HEIGHT - 4, "end", day(span[1])[:10])]
    labels = "".join(f'<text x="{x}" y="{y}" text-anchor="{at}">{escaped(text)}</text>' for x, y, at, text in texts)
    _, last, sd, unit = points[-1]
    return (f"<div><p><b>{escaped(name)}</b> {figure(last, 4)} ± {figure(sd, 2)} {escaped(unit)}{rate_text(usual)}</p>"
            f'<svg viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" role="img" aria-label="{escaped(name)} over date">'
            f'<polygon class="band" points="{frame.band(usual)}"/><rect class="frame" x="{LEFT}" y="{TOP}" '
            f'width="{right - LEFT}" height="{bottom - TOP}"/>{lines}'
            f'<polyline class="value" points="{value}"/>{dots}{labels}</svg></div>')


def arm_row(arm, anchor, records, findings, span):
    fits = [record.found["fit_percent"] for record in records if record.found["fit_percent"] is not None]
    told = ", ".join(dict.fromkeys(f.what for f in findings)) or "nothing found"
    dates = list(dict.fromkeys(day(record.date) for record in (records[0], records[-1])))
    summary = f"{pages.counted(len(records), 'record')}, {' to '.join(dates)}"
    if fits:
        summary += f"; fit {min(fits):.1f} to {max(fits):.1f} %"
    panels = "".join(panel(name, points, span, [f.since for f in findings if f.what == name])
                     for name, points in series_of(records).items())
    return (f'<h3 id="{anchor}">{escaped(arm)}: {escaped(told)} <small>({escaped(summary)})</small></h3>'
            f'<div class="trends">{panels}</div>')


def heading(found, arms):
    return f"{found} of {pages.counted(arms, 'arm')} {'has' if found == 1 else 'have'} something"


def page(job, records, findings, rows):
    arms = by_arm(records)
    failed = [row for row in rows if row["what"] == "failed"]
    order = list(dict.fromkeys([f.arm for f in findings] + list(arms)))
    anchors = {arm: f"arm{k}" for k, arm in enumerate(order)}
    dates = [record.date for own in arms.values() for record in own]
    parts = [f"<h1>{heading(len({f.arm for f in findings}), len(arms))}</h1>",
             f"<p>{pages.counted(len(records), 'record')}, {len(failed)} of which failed; {escaped(job)}.</p>",
             found_table(findings, anchors) if findings else "<p>Nothing was found.</p>"]
    if failed:
        parts += ["<h2>Records that failed</h2>", table(("arm", "date", "what armukf says"), (
            (row["arm"], row["since"], row["note"]) for row in failed))]
    if arms:
        parts.append("<h2>Trends</h2><p>Each parameter over date with its 90 % band, worst arm first; dashed: since "
                     "when it is another; hollow: stands alone, as a fit does that has gone astray, and is left out.</p>")
        span = (min(dates), max(dates))
        parts += [arm_row(arm, anchors[arm], arms[arm], [f for f in findings if f.arm == arm], span) for arm in order]
    return pages.page("armukf fleet", "\n".join(parts), STYLE)
