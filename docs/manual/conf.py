# The manual: docs/*.md and the pages that they link to, as HTML (Sphinx, MyST, Furo). The source folder is the project's, so that the links
# of the Markdown files hold; a link to any other file of the project becomes a copy of it in _downloads. Nothing comes from the network, and
# the same sources give the same bytes. cmake/manual.cmake calls it.
import os
import re
from pathlib import Path

from sphinx import addnodes

project = "Thimble"
copyright = "Thimble maintainers"
release = os.environ.get("THIMBLE_VERSION", "")
version = release
root_doc = "docs/index"
include_patterns = ["docs/*.md", "docs/api/*.md", "board/README.md", "board/linux/reference/*/README.md", "scenes/README.md",
                    "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"]
exclude_patterns = ["build", ".*", "**/node_modules", "tests", "firmware", "control", "kinematics", "host-tools"]

extensions = ["myst_parser", "sphinx_copybutton", "breathe", "sphinx.ext.autodoc"]
nitpicky = True  # every link and anchor of the pages; types of C++ and Python that have no page are not links
nitpick_ignore_regex = [("cpp:.*", ".*"), ("py:.*", ".*")]
myst_heading_anchors = 4
highlight_language = "text"
copybutton_exclude = ".linenos, .gp, .go"

breathe_projects = {"thimble": os.environ.get("THIMBLE_DOXYGEN_XML", "")}
breathe_default_project = "thimble"
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = f"Thimble {release}".strip()
html_extra_path = ["top"]  # index.html, which leads to the first page
html_last_updated_fmt = None
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}


def folder_is_no_page(app, doctree):
    """A link to a folder of the project: its name alone, because the manual has no folders."""
    here = Path(app.env.doc2path(app.env.docname)).parent
    for node in list(doctree.findall(addnodes.pending_xref)):
        if (here / node["reftarget"]).is_dir():
            node.replace_self(node.children)


def plain_docstring(app, what, name, obj, options, lines):
    """The docstrings are plain text, not reStructuredText: what has a meaning there is escaped, `...` and indented lines are code."""
    out = []
    for line in lines:
        if line.startswith("    "):
            out += [] if out and (out[-1].startswith("    ") or len(out) > 1 and out[-2].startswith("    ")) else ["::", ""]
            out.append(line)
            continue
        parts = line.split("`")
        out.append("``".join(re.sub(r"([*_|\\])", r"\\\1", part) if i % 2 == 0 else part for i, part in enumerate(parts)))
    lines[:] = out


def mend_furo(app, exception):
    """Debian's Furo 2022.12 has its script and its styles as they are before they are bundled: they import other files, by a path of the
    machine and as a module, which no browser loads from a file. And it has no dark colours for who has chosen none, which the system may prefer."""
    static = Path(app.outdir, "_static")
    script, style = static / "scripts/furo.js", static / "styles/furo.css"
    if exception or not script.exists():
        return
    gumshoe = (static / "scripts/gumshoe-patched.js").read_text()
    script.write_text(re.sub(r"^import Gumshoe .*\n", lambda it: gumshoe, script.read_text()))
    text = re.sub(r"^@import url\((.*?)\);", lambda it: Path("/usr/share" + it[1]).read_text(), style.read_text())
    if "prefers-color-scheme" not in text:
        dark = re.search(r'body\[data-theme="dark"\] (\{[^}]*\})', text)[1]
        text += '@media (prefers-color-scheme: dark) { body:not([data-theme="light"]) ' + dark + " }\n"
    style.write_text(text)


def forget_schemas(app, exception):
    """A scene that is downloaded from a page has no schema beside it."""
    for file in Path(app.outdir, "_downloads").rglob("*.json"):
        file.write_text(re.sub(r'^ *"\$schema": "[^"]+",\n', "", file.read_text(), count=1, flags=re.M))


def setup(app):
    app.connect("doctree-read", folder_is_no_page)
    app.connect("autodoc-process-docstring", plain_docstring)
    app.connect("build-finished", mend_furo)
    app.connect("build-finished", forget_schemas)
