"""Pages of lessons, which the site carries as files, are opened by their links and not saved."""

from __future__ import annotations

from docutils import nodes
from sphinx.addnodes import download_reference
from sphinx.application import Sphinx


def open_pages(app: Sphinx, tree: nodes.document, page: str) -> None:
    """Turn links that save an HTML file into links that open it."""
    for node in list(tree.findall(download_reference)):
        name = node.get("filename", "")
        if name.endswith(".html"):
            link = nodes.reference("", "", refuri=f"{'../' * page.count('/')}_downloads/{name}", internal=True)
            link.extend(node.children)
            node.replace_self(link)


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at every page once its links are resolved."""
    app.connect("doctree-resolved", open_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
