"""What is offered stands on the page that lists it."""

from __future__ import annotations

import re
from types import ModuleType

import pages
import pytest

import symdyn
from symdyn import identification, study


@pytest.mark.parametrize("room", [symdyn, identification, study], ids=lambda room: room.__name__)
def test_every_door_and_noun_stands_on_the_page_of_doors(room: ModuleType) -> None:
    """`excite`, `output_error`, `Indices` and `Uncertainty` were missing."""
    page = (pages.DOCS / "api.md").read_text(encoding="utf-8")
    listed = re.findall(r"auto\w+:: symdyn[.\w]*\.(\w+)$", page, re.MULTILINE)
    doors = [name for name in room.__all__ if callable(getattr(room, name)) and not name.endswith("Error")]

    assert [name for name in doors if name not in listed] == []
