"""Generated files with one piece of text changed, and what is then known of them."""

from __future__ import annotations

from dataclasses import replace

import symdyn
from symdyn.emit import emit
from symdyn.program import Program
from symdyn.verify.building import files_of
from symdyn.verify.written import READERS, Written, printed, prove_texts


def two_link_with(*outputs: str) -> Program:
    return symdyn.program.lower(symdyn.dynamics.derive(symdyn.example("two_link"), outputs))


def altered(program: Program, target: str, old: str, new: str, file: str = "", option: str = "") -> Written:
    """Return what is known of a file, the first one if none is named, in which a text is changed at its first place."""
    files = files_of(emit(program, target, option=option))
    name = file or next(iter(files.contents))
    text = files.contents[name]
    assert isinstance(text, str)
    assert old in text
    changed = replace(files, contents={**files.contents, name: text.replace(old, new, 1)})
    found = prove_texts(printed(program, "double"), changed, READERS[target], files.contents)
    assert all(one.passed for one in found if one.file != name)
    return next(one for one in found if one.file == name)
