"""Sphinx settings of the manual. scripts/manual_pages.py puts this folder beside what it generates."""

import __future__
import os
import re
import shutil
import sys
import types
from pathlib import Path

from docutils.nodes import SkipNode

TREE = Path(os.environ["ARMUKF_TREE"])  # the top of the source tree; scripts/manual sets it
PACKAGE = TREE / "lib/python"
KATEX = Path("/usr/share/javascript/katex")  # Debian's libjs-katex

project = "armukf"
author = "the armukf authors"
version = release = os.environ.get("ARMUKF_VERSION", "")
extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3

smartquotes = False  # -- is an option's

html_theme = "furo"
html_title = "armukf"
html_static_path = ["look"]
html_css_files = ["katex/katex.min.css", "manual.css"]
html_js_files = [("katex/katex.min.js", {"defer": "defer"}), ("equations.js", {"defer": "defer"})]
html_math_renderer = "katex"
html_copy_source = html_show_sourcelink = html_show_copyright = False
html_theme_options = {"light_css_variables": {"color-brand-primary": "#00588a", "color-brand-content": "#00588a"}}

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_class_signature = "mixed"
python_use_unqualified_type_names = True
nitpicky = True
nitpick_ignore_regex = [  # what other projects document, and names that stand for unions
    ("py:.*", r"(numpy|np|pandas|typing|collections|os|enum|builtins)(\..*)?"),
    ("py:.*", r"(NDArray|Floats|ModelSource|Any|Callable|Mapping|Sequence|Literal|Record|Records|Path|FreeInitial)"),
    ("py:.*", r"(float64|uint8|PathLike|DataFrame|dtype|_ScalarType_co|Ellipsis|IntEnum|_Found|ValueError).*"),
]


def described_core():
    """The compiled module's place is taken by its description, _core.pyi, which is Python."""
    path = PACKAGE / "armukf/_core.pyi"
    core = types.ModuleType("armukf._core")
    core.version, core.processor = version, ""
    flags = __future__.annotations.compiler_flag
    exec(compile(path.read_text(encoding="utf-8"), path, "exec", flags=flags), core.__dict__)
    core.InputError.__doc__ = "What the caller got wrong, in the words of the program."
    return core


def described_package():
    """A copy of the package in which the comments behind fields are documentation."""
    copy = Path(__file__).parent / "python"
    shutil.copytree(PACKAGE / "armukf", copy / "armukf", dirs_exist_ok=True)
    for path in (copy / "armukf").glob("*.py"):
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r"^(    \w+(?:: .*?| = \d+)  )# ", r"\1#: ", text, flags=re.MULTILINE), encoding="utf-8")
    return copy


sys.dont_write_bytecode = True
sys.path.insert(0, str(described_package()))
sys.modules["armukf._core"] = described_core()


def plain_docstring(app, what, name, thing, options, lines):
    """Docstrings are plain text: bars are bars, and what is indented is code."""
    told, outer = [], True
    for line in lines:
        inner = line.startswith("    ")
        if inner and outer:
            told += ["::", ""]
        if line.strip():
            outer = not inner
        told.append(line if inner else line.replace("|", "\\|"))
    lines[:] = told


def equation(writer, node, tag):
    writer.body.append(f'<{tag} class="equation">{writer.encode(node.astext())}</{tag}>')
    raise SkipNode


def copy_katex(app, error):
    if error is None and app.builder.format == "html":
        to = Path(app.outdir) / "_static/katex"
        to.mkdir(parents=True, exist_ok=True)
        for name in ("katex.min.js", "katex.min.css"):
            shutil.copyfile(KATEX / name, to / name)
        (to / "fonts").mkdir(exist_ok=True)
        for font in (KATEX / "fonts").glob("*.woff2"):
            shutil.copyfile(font, to / "fonts" / font.name)


def setup(app):
    app.add_html_math_renderer("katex", (lambda writer, node: equation(writer, node, "span"), None),
                               (lambda writer, node: equation(writer, node, "div"), None))
    app.connect("autodoc-process-docstring", plain_docstring)
    app.connect("build-finished", copy_katex)
