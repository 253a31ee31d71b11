"""The JavaScript target: functions of plain arrays that need nothing else, for browsers and Node alike.

    <scene>.mjs    an ES module:    import { mass_matrix } from "./two_link.mjs";
    <scene>.js     a plain script:  <script src="two_link.js"></script>, then symdyn.two_link.mass_matrix(q, params)

Both hold the same code; the script also works in a page opened from a disk, where browsers load no modules.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from symdyn.emit.names import stem
from symdyn.emit.page import compose
from symdyn.emit.real import Real, digits
from symdyn.emit.render import render
from symdyn.emit.spelling import OPERATORS, Printer, Spelling, call
from symdyn.errors import EmitError
from symdyn.graph import Op
from symdyn.program import Program

JAVASCRIPT: Mapping[Op, Spelling] = {
    **OPERATORS,
    Op.SIN: call("Math.sin"),
    Op.COS: call("Math.cos"),
    Op.SQRT: call("Math.sqrt"),
    Op.EXP: call("Math.exp"),
    Op.LOG: call("Math.log"),
    Op.TANH: call("Math.tanh"),
    Op.ABS: call("Math.abs"),
    Op.SIGN: call("Math.sign"),
    Op.ATAN2: call("Math.atan2", 2),
}


def emit_js(program: Program, real: Real, command: str) -> tuple[tuple[str, str], ...]:
    """Return the ES module and the plain script, by name; the module comes first.

    Raises:
        EmitError: a real type other than double, the only one that JavaScript computes in.
    """
    if real.name != "double":
        raise EmitError(f"real type {real.name!r}: JavaScript computes in doubles; leave it out")
    page = compose(program, Printer(JAVASCRIPT, partial(digits, real=real)), command)
    name = stem(program.scene.name)
    values = {
        "page": page,
        "about": render("common/about.txt.jinja", {"page": page}).rstrip("\n"),
        "name": name,
        "scalars": any(function.scalars for function in page.functions),
    }
    return tuple(
        (f"{name}.{ending}", render("js/module.js.jinja", {**values, "script": ending == "js"}))
        for ending in ("mjs", "js")
    )
