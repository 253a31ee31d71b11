"""The words that readers search for lead to the sections that are meant: search_words.toml as main index entries."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform
from sphinx.util import logging

TABLE = Path(__file__).parent / "search_words.toml"


@cache
def words() -> dict[str, dict[str, list[str]]]:
    """Return the words of the table by page and by section; "" is the page itself."""
    found: dict[str, dict[str, list[str]]] = {}
    for where, names in tomllib.loads(TABLE.read_text(encoding="utf-8")).items():
        page, _, section = where.partition("#")
        found.setdefault(page, {})[section] = names
    return found


class SearchWords(SphinxTransform):
    """Put the words of a page into its sections, before domains collect their entries."""

    default_priority = 840

    def apply(self) -> None:
        """Add index entries below the sections that the table names; one that is not there is a warning."""
        for section, names in words().get(self.env.docname, {}).items():
            found = [one for one in self.document.findall(nodes.section) if not section or section in slugs(one)]
            if not found:
                logging.getLogger(__name__).warning("no section #%s, which %s names", section, TABLE.name)
                continue
            target = found[0]["ids"][0]
            entries = [("single", name, target, "main", None) for name in names]
            found[0].insert(1, addnodes.index(entries=entries, inline=False))


def slugs(section: nodes.section) -> set[str]:
    """Return the names by which links find a section: those of docutils, and that of GitHub."""
    return {*section["ids"], *([section["slug"]] if "slug" in section else [])}


def setup(app: Sphinx) -> dict[str, bool]:
    """Transform every page; a page that the table names and that is gone is a warning."""
    app.add_transform(SearchWords)
    app.connect("env-updated", look_for_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def look_for_pages(app: Sphinx, env: object) -> None:
    """Warn of pages that are not there."""
    for page in words().keys() - app.env.found_docs:
        logging.getLogger(__name__).warning("no page %s, which %s names", page, TABLE.name)
