"""How the pages of docs become a site: `make docs` writes it to build/site, `make notebooks` runs its notebooks.

Every page is plain Markdown or a notebook, which GitHub shows as well; the site adds search, the API and mathematics.
Nothing in it is loaded from another address: formulas are MathML, scripts and fonts lie beside the pages.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

INSTALL = "pip install ."
"""The line that works today. README.md, index.md and start.md hold it; tests/test_docs_pages.py holds them to it."""

project = "symdyn"
author = "the authors of symdyn"
copyright = "the authors of symdyn, MIT licence"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "mathml_formulas",
    "shown_docstrings",
    "opened_files",
    "try_it",
    "api_pages",
    "search_words",
]
exclude_patterns = ["site", "walkthroughs/*.ipynb"]
suppress_warnings = ["myst.header"]  # a page of a lesson may begin with its second level

myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False
nb_execution_mode = "off"  # outputs are stored; `make notebooks` rewrites them

html_math_renderer = "mathml"
default_role = "code"  # what docstrings put between backticks

autosummary_generate = False  # `api_pages` does
autodoc_member_order = "bysource"
python_maximum_signature_line_length = 80
autodoc_preserve_defaults = False  # it takes signatures for those in the source, which `**fields` have not
autodoc_typehints = "signature"
napoleon_use_rtype = False
napoleon_attr_annotations = False  # docstrings tell shapes; types of arrays in full do not help

html_theme = "furo"
html_title = "symdyn"
html_favicon = "static/icon.svg"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_search_scorer = str(Path(__file__).parent / "scorer.js")
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}
templates_path = [str(Path(__file__).parent / "templates")]
llms_about = "Equations of motion of mechanisms: declared once, derived twice, proved equal; simulation, control, code."
