"""Sphinx configuration of the documentation; ``make docs`` builds it, without a network."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

import myostrain

project = "myostrain"
author = "The myostrain authors"
copyright = author  # noqa: A001 - Sphinx wants this name
version = release = myostrain.__version__
language = "en-GB"

# Ours are in the folder extensions.
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "myst_nb",  # pages of MyST and notebooks
    "mathml",
    "docstrings",
    "search_texts",
]
myst_enable_extensions = ["dollarmath", "deflist", "attrs_inline", "colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # the tutorials hold what they show; a test runs them
html_math_renderer = "mathml"
nitpicky = False

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say what arguments mean, with shapes and allowed values
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"myostrain {version}"
html_static_path = ["_static"]
html_css_files = ["formulas.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
pygments_style = "friendly"
pygments_dark_style = "monokai"
