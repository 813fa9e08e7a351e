"""Formulas as MathML in the page itself: no script, no font, no network."""

import re

from myostrain.reproduce.formulas import mathml

from docutils import nodes
from sphinx.util import logging

log = logging.getLogger(__name__)

#: Left in the MathML by LaTeX that latex2mathml does not know, or that browsers do not show.
SUSPECT = re.compile(r">(&|\\\\?\w*)<|\\[a-zA-Z]|merror|mathvariant=\"(?!normal)")


def convert(node: nodes.Node, *, display: bool) -> str:
    latex = node.astext()
    made = mathml(latex, display=display)
    if SUSPECT.search(made):
        log.warning("latex2mathml does not know all of %s", latex, location=node)
    return made


def visit_math(self, node: nodes.Node) -> None:
    self.body.append(convert(node, display=False))
    raise nodes.SkipNode


def visit_displaymath(self, node: nodes.Node) -> None:
    self.body.append(f'<div class="formula">{convert(node, display=True)}</div>\n')
    raise nodes.SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
