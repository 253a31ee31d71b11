"""Docstrings as pages: what stands further in, below an empty line, keeps its lines, as formulas and examples do."""

from __future__ import annotations

import re

from sphinx.application import Sphinx

BEFORE_NAPOLEON = 400

BARS = re.compile(r"\|(?=[^`]*(?:`[^`]*`[^`]*)*$)")
"""Bars outside of backticks: |x| is a size, and no substitution."""


def keep_lines(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Turn blocks that stand further in than the line above them into literal ones."""
    found: list[str] = []
    literal = margin = 0
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if line.strip():
            if literal and indent < literal:
                literal = 0
            if (
                not literal
                and found
                and not found[-1].strip()
                and indent > margin
                and not line.lstrip().startswith(">>>")
            ):
                found += [" " * margin + "::", ""]
                literal = indent
            if not literal:
                margin = indent
        found.append(line if literal else BARS.sub(r"\|", line))
    lines[:] = found


def setup(app: Sphinx) -> dict[str, bool]:
    """Read docstrings this way, before Napoleon sees them."""
    app.connect("autodoc-process-docstring", keep_lines, priority=BEFORE_NAPOLEON)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
