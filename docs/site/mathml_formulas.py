"""Formulas of the site as MathML, so that no page needs a script, a font or a network for them."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

from symdyn.teach.mathematics import inner

NUMBER = r"\\qquad \\text{(\1)}"

TAG = re.compile(r"\\tag\{([^{}]*)\}")


def in_a_line(writer: Any, node: nodes.math) -> None:
    """Write a formula that stands in a line."""
    writer.body.append(f"<math>{inner(node.astext())}</math>")
    raise nodes.SkipNode


def on_its_own(writer: Any, node: nodes.math_block) -> None:
    """Write a formula that has lines of its own, which scroll where they are wider than the page."""
    formula = f'<math display="block">{inner(TAG.sub(NUMBER, node.astext()))}</math>'
    writer.body.append(f"{writer.starttag(node, 'div', '', CLASS='math')}{formula}</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Make this the way in which formulas are written."""
    app.add_html_math_renderer("mathml", inline_renderers=(in_a_line, None), block_renderers=(on_its_own, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
