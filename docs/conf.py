"""Settings of the documentation: ``python -m sphinx -W docs docs/_build`` builds it."""

import re
import sys
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

import cpm_core  # noqa: E402
from docs.making import pages  # noqa: E402

project = "CPM"
author = "The CPM authors"
copyright = f"{author}. MIT license"
version = release = cpm_core.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "sphinx.ext.viewcode"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "_made/*.md"]  # parts that pages include
default_role = "code"

autodoc_default_options = {"members": True, "inherited-members": True}
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"CPM {release}"
html_static_path = ["_static"]
html_css_files = ["tables.css"]
html_theme_options = {"navigation_with_keys": True}

pages.make(HERE / "_made")


def told_as_text(_app: object, _what: str, _name: str, _given: object, _options: object, lines: list[str]) -> None:
    """Leave types such as "ndarray, shape (H, W)" as they are: their words name nothing that could be linked."""
    for place, line in enumerate(lines):
        lines[place] = re.sub(r"^(:(?:var)?type \S+: )(.*\bshape\b.*)$", r"\1*\2*", line)


def setup(app: Sphinx) -> None:
    """Connect what changes docstrings, after those of NumPy's form have been read."""
    app.connect("autodoc-process-docstring", told_as_text, priority=600)
