"""What the API reference lists, as the site reads it: docs/site/api_catalogue.py, which imports no Sphinx."""

from __future__ import annotations

import sys

import pages

sys.path.insert(0, str(pages.DOCS / "site"))

from api_catalogue import CONSTRUCTED, GROUPS, catalogue, examples, members, object_of  # type: ignore[import-not-found]

__all__ = ["CONSTRUCTED", "GROUPS", "catalogue", "examples", "members", "object_of"]
