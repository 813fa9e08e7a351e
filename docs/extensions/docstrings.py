"""Docstrings are plain text with a little mark-up: keep |F f₀| from being read as more."""

import re

#: Stands for a colon while napoleon, which takes what precedes one for the type of a property, has its turn.
COLON = "\ue000"


def protect(app, what, name, obj, options, lines):
    """Escape bars and stars outside of code, in place; Sphinx would take |x| for a substitution."""
    for number, line in enumerate(lines):
        parts = re.split(r"(``.*?``)", line)
        parts[::2] = [re.sub(r"(?<!\\)([|*])", r"\\\1", part) for part in parts[::2]]
        lines[number] = "".join(parts)
        if what in ("property", "attribute"):
            lines[number] = re.sub(r":(?=\s)", COLON, lines[number])


def restore(app, what, name, obj, options, lines):
    """Put the colons back."""
    lines[:] = [line.replace(COLON, ":") for line in lines]


def setup(app):
    app.connect("autodoc-process-docstring", protect, priority=100)  # before napoleon
    app.connect("autodoc-process-docstring", restore, priority=900)  # after it
    return {"parallel_read_safe": True, "parallel_write_safe": True}
