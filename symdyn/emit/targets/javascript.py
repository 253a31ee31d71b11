"""The JavaScript target: functions of plain arrays that need nothing else, for browsers and Node alike.

    <scene>.mjs    an ES module:    import { mass_matrix } from "./two_link.mjs";
    <scene>.js     a plain script:  <script src="two_link.js"></script>, then symdyn.two_link.mass_matrix(q, params)

Both hold the same code; the script also works in a page opened from a disk, where browsers load no modules.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from symdyn.emit.code.spelling import OPERATORS, TABLE, Printer, Spelling, call, digits
from symdyn.emit.code.target import Draft, Target
from symdyn.emit.render import in_comment, render
from symdyn.graph import ELEMENTARY, Op

SPELLINGS: Mapping[Op, Spelling] = {
    **OPERATORS,
    **{op: call(f"Math.{op.name.lower()}") for op in (*ELEMENTARY, Op.ABS, Op.SIGN)},
    **{op: call(f"Math.{op.name.lower()}", 2) for op in (Op.ATAN2, Op.POW)},
    Op.SELECT: call("_select", 3),
    Op.TABLE: TABLE,
}

KEYWORDS = """arguments await break case catch class const continue debugger default delete do else enum eval export
extends false finally for function if implements import in instanceof interface let new null package private protected
public return static super switch this throw true try typeof var void while with yield
Array ArrayBuffer Float64Array Math RangeError TypeError globalThis out"""
"""Reserved words, and what the module itself calls by its name."""


def _write(draft: Draft) -> dict[str, str]:
    """Return the ES module and the plain script."""
    values = {
        "page": draft.page,
        "about": draft.about,
        "name": draft.stem,
        "scalars": any(function.scalars for function in draft.page.functions),
    }
    return {
        f"{draft.stem}{ending}": render("js/module.js.jinja", {**values, "script": ending == ".js"})
        for ending in (".mjs", ".js")
    }


JS = Target(
    name="js",
    title="JavaScript",
    text="JavaScript, which computes in doubles, one state a call",
    files={"{stem}.mjs": str, "{stem}.js": str},
    keywords=frozenset(KEYWORDS.split()),
    printer=lambda real: Printer(SPELLINGS, partial(digits, real=real)),
    comment=in_comment,
    write=_write,
)
