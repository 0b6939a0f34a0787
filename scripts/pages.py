"""Self-contained HTML pages. All text is escaped but Markup."""

import html

STYLE = """body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.25em .6em;text-align:left}
img{max-width:100%}figure{margin:1.5em 0}figcaption{color:#555}.wide{overflow-x:auto}"""


class Markup(str):
    """HTML that is meant as such."""


def escaped(text):
    return text if isinstance(text, Markup) else Markup(html.escape(str(text)))


def table(head, lines):
    rows = "".join("<tr>" + "".join(f"<td>{escaped(c)}</td>" for c in line) + "</tr>" for line in lines)
    heads = "".join(f"<th>{escaped(h)}</th>" for h in head)
    return Markup(f'<div class="wide"><table><tr>{heads}</tr>{rows}</table></div>')


def page(title, body, style=""):
    return ('<!doctype html><html lang="en"><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{escaped(title)}</title><style>{STYLE}{style}</style><body>\n{body}\n</body></html>\n")
