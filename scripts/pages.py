"""Self-contained HTML pages. All text is escaped but Markup."""

import base64
import hashlib
import html
import json

STYLE = """body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.25em .6em;text-align:left}
img{max-width:100%}figure{margin:1.5em 0}figcaption{color:#555}.wide{overflow-x:auto}"""
# What would end a script element, or a line of one.
UNSAFE = {ord(c): f"\\u{ord(c):04x}" for c in "<>&\u2028\u2029"}


class Markup(str):
    """HTML that is meant as such."""


def escaped(text):
    return text if isinstance(text, Markup) else Markup(html.escape(str(text)))


def element(tag, *content, **attributes):
    """`class_` and `for_` stand for class and for."""
    told = "".join(f' {name.rstrip("_").replace("_", "-")}="{html.escape(str(value))}"'
                   for name, value in attributes.items() if value is not None)
    return Markup(f"<{tag}{told}>{''.join(escaped(part) for part in content)}</{tag}>")


def table(head, lines):
    rows = "".join("<tr>" + "".join(f"<td>{escaped(c)}</td>" for c in line) + "</tr>" for line in lines)
    heads = "".join(f"<th>{escaped(h)}</th>" for h in head)
    return Markup(f'<div class="wide"><table><tr>{heads}</tr>{rows}</table></div>')


def counted(number, noun):
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def page(title, body, style=""):
    return ('<!doctype html><html lang="en"><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{escaped(title)}</title><style>{STYLE}{style}</style><body>\n{body}\n</body></html>\n")


def fingerprint(text):
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"


def drawn_page(title, body, style, scripts, content):
    """A page whose scripts draw `content`. Its policy lets nothing run or load but those scripts and that style, and
    no text become markup."""
    policy = (f"default-src 'none'; script-src {' '.join(map(fingerprint, scripts))}; style-src {fingerprint(style)}; "
              "img-src data:; base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'")
    told = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).translate(UNSAFE)
    run = "".join(f"<script>{script}</script>\n" for script in scripts)
    return ('<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<title>{escaped(title)}</title>\n<link rel="icon" href="data:,">\n<style>{style}</style>\n</head>\n'
            f'<body>\n{body}\n<script type="application/json" id="content">{told}</script>\n{run}</body>\n</html>\n')
