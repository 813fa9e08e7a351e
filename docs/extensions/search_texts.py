"""Excerpts in the search, also where a site is opened as files, of which a browser fetches none."""

import json
import re
from pathlib import Path

NAME = "search_texts.js"

SCRIPT = """// What the search shows excerpts of; a page that is opened as a file cannot fetch others.
const TEXTS = @TEXTS;
const fetched = window.fetch.bind(window);
window.fetch = (address, ...others) => {
  const name = String(address).replace(/^\\.\\//, "");
  return name in TEXTS ? Promise.resolve(new Response(TEXTS[name])) : fetched(address, ...others);
};
"""


def contents(page: str) -> str:
    """The main part of a page, without marks of headings, links, spans and formulas."""
    found = re.search(r'<article role="main".*?</article>', page, re.S)
    text = re.sub(r'<a class="headerlink".*?</a>', "", found[0], flags=re.S) if found else ""
    return re.sub(r"</?(?:span|a)\b[^>]*>|<(math|svg)\b.*?</\1>", "", text, flags=re.S)


def add(app, pagename, templatename, context, doctree):
    """The page of the search loads the texts."""
    if pagename == "search":
        app.add_js_file(NAME)


def write(app, exception):
    """Write the texts of all pages."""
    if exception is None and app.builder.format == "html":
        folder = Path(app.outdir)
        texts = {
            str(path.relative_to(folder)): contents(path.read_text(encoding="utf-8"))
            for path in sorted(folder.rglob("*.html"))
            if path.name not in ("search.html", "genindex.html") and "_modules" not in path.parts
        }
        script = SCRIPT.replace("@TEXTS", json.dumps(texts, ensure_ascii=False))
        (folder / "_static" / NAME).write_text(script, encoding="utf-8")


def setup(app):
    app.connect("html-page-context", add)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
