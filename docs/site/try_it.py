"""Links of the site that say *Try it* open the playground itself, where `make playground` has made it.

Elsewhere, as on GitHub, they lead to the page that says how it is opened.
"""

from __future__ import annotations

from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx

MADE = Path(__file__).parent.parent.parent / "build" / "playground" / "index.html"
SAYS = "Try it"


def open_playground(app: Sphinx, tree: nodes.document, page: str) -> None:
    """Turn the links into those to the playground, which `make docs` copies into the site."""
    for node in list(tree.findall(nodes.reference)):
        if MADE.is_file() and node.astext().startswith(SAYS):
            node["refuri"] = f"{'../' * page.count('/')}playground/index.html"


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at every page once its links are resolved."""
    app.connect("doctree-resolved", open_playground)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
