"""The WebAssembly target: the interface of JavaScript's, computed by code of our own that no compiler is needed for.

    <scene>_wasm.mjs   an ES module that holds the code:   import { mass_matrix } from "./two_link_wasm.mjs";
    <scene>_wasm.js    a plain script that holds it too, for pages opened from a disk
    <scene>.wasm       the code alone, for other programs

Functions of the code take the address from which on they may use memory. Entries of the arguments stand there, one
after another, then those of the result; for `name_batch(address, count)` each of them is a column, of at most BLOCK
states, and STRIDE bytes after the one before.
"""

from __future__ import annotations

from base64 import b64encode
from itertools import accumulate
from typing import Any

from symdyn.emit.code.real import REALS
from symdyn.emit.code.source_text import FunctionText
from symdyn.emit.code.target import Contents, Draft, Target, alone
from symdyn.emit.escape import in_comment
from symdyn.emit.render import render
from symdyn.emit.targets.javascript import JS
from symdyn.emit.targets.wasm.binary import BLOCK, STRIDE, binary
from symdyn.errors import EmitError
from symdyn.program import shared

BATCH = "batch"

NAMES = "Uint8Array WebAssembly atob memory count Number"
"""What the module calls by its name, beside what JavaScript's does."""


def _write(draft: Draft) -> dict[str, Contents]:
    """Return the ES module, the plain script and the code."""
    page, batch = draft.page, draft.option == BATCH
    names = tuple(function.name for function in page.functions)
    for name in names if batch else ():
        if f"{name}_batch" in names:
            raise EmitError(f"function {name}_batch would be called as {name} for many states is; rename it")
    code = binary(draft.program, names, batch, in_comment(page.command, prefix=""))
    values = {
        "page": page,
        "about": draft.about,
        "name": draft.stem,
        "scalars": any(function.scalars for function in page.functions),
        "code": b64encode(code).decode(),
        "places": {function.name: _places(function) for function in page.functions},
        "batch": batch,
        "block": BLOCK,
        "stride": STRIDE // 8,
    }
    texts = {end: render("wasm/module.js.jinja", {**values, "script": end == ".js"}) for end in (".mjs", ".js")}
    return {**{f"{draft.stem}_wasm{end}": text for end, text in texts.items()}, f"{draft.stem}.wasm": code}


def _places(function: FunctionText) -> dict[str, Any]:
    """Return where a function reads what it needs of its arguments, and where its results stand, in numbers from 0.

    `common` is the argument that all states have in common.
    """
    starts = accumulate((argument.length for argument in function.arguments), initial=0)
    first = {argument.name: start for argument, start in zip(function.arguments, starts, strict=False)}
    return {
        "inputs": [(name, entry, first[name] + entry) for _, name, entry in function.inputs],
        "results": sum(argument.length for argument in function.arguments),
        "common": shared([argument.name for argument in function.arguments]),
    }


WASM = Target(
    name="wasm",
    title="WebAssembly",
    text="WebAssembly with a module of JavaScript around it, in doubles",
    reals=("double",),
    options={BATCH: "functions over many states too, two at a time"},
    files={"{stem}_wasm.mjs": str, "{stem}_wasm.js": str, "{stem}.wasm": bytes},
    first=0,
    keywords=JS.keywords | frozenset(NAMES.split()),
    lacks={},
    functions=None,
    tunes=False,
    printer=lambda real: JS.printer(REALS["double"]),
    comment=in_comment,
    write=_write,
    beside=alone,
    shortens=(),
    loops=False,
)
