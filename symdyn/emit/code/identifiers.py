"""Names in generated code: legal where they stand, and never taken already.

Of C those stand outside of functions that are for callers, and a file's own, which nobody else must meet:

    <stem>_<function>         for callers
    <stem>_own_<name>         a header's own functions, types and tables, which may stand beside those of others
    SYMDYN_<NAME>             macros; a header takes them back in its end
    SYMDYN_<stem>_H           the guard of a header, in the letters of the scene: Arm and arm are two

In a source file, which is a translation unit, what is its own is called by its name alone.
"""

from __future__ import annotations

import keyword
import re
import sys
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from typing import Any

from symdyn.emit.render import render
from symdyn.errors import EmitError
from symdyn.program import identifier
from symdyn.resources import folder
from symdyn.scene.values import RESERVED

C_HEADERS = """alloca assert complex ctype endian errno features fenv float inttypes iso646 limits locale math pthread
sched setjmp signal stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings syslimits
tgmath threads time uchar unistd wchar wctype"""
"""Headers of C, and those that they open, without .h."""


MATLAB = """case catch classdef elseif end endfor endfunction endif endparfor endswitch endwhile function otherwise
parfor persistent spmd until unwind_protect"""
"""Words that no package of MATLAB or Octave can have, and no name of C or Python has yet."""


DEVICES = re.compile(r"(con|prn|aux|nul|(com|lpt)\d)\Z", re.IGNORECASE)


def stem(scene: str) -> str:
    """Return the file name of a scene without its ending, which also opens the names of its C functions.

    A scene called numpy or math would hide the module or header that its own code needs, sin the function; a package
    of MATLAB is not called end, and Windows writes no file called CON.c; each gets an underscore.
    """
    name = identifier(scene) or "scene"
    if not name[0].isalpha():
        name = f"m{name}"
    module = name == "numpy" or keyword.iskeyword(name) or name in sys.stdlib_module_names
    words = (*C_HEADERS.split(), *MATLAB.split(), *RESERVED)
    return f"{name}_" if module or name in words or is_device(name) else name


@cache
def names_of_c() -> frozenset[str]:
    """Return what headers of C and POSIX call theirs outside of functions: functions, types, constants, macros.

    `python -m tests.names_of_headers` made the list.
    """
    lines = (folder("templates") / "c" / "names_of_headers.txt").read_text(encoding="utf-8").splitlines()
    return frozenset(name for line in lines if not line.startswith("#") for name in line.split())


def page_stem(scene: str) -> str:
    """Return the file name of a scene's pages without ending; that of a device of Windows gets an underscore."""
    return f"{scene}_" if is_device(scene) else scene


def is_device(name: str) -> bool:
    """Tell whether Windows takes a file of this name, with any ending, for a device."""
    return DEVICES.match(name) is not None


def function_names(names: Sequence[str], keywords: Collection[str] = (), begin: str = "") -> list[str]:
    """Return legal names for functions, in order; one of the target's keywords gets an underscore.

    Args:
        names: what they were asked for as.
        keywords: of the target.
        begin: what stands in front of every name in C; one that headers have, such as sem_wait, gets one, too.

    Raises:
        EmitError: two of them become one.
    """
    legal: dict[str, str] = {}
    taken = names_of_c() if begin else frozenset[str]()
    for name in names:
        plain = identifier(name)
        plain = f"{plain}_" if plain in keywords or f"{begin}{plain}" in taken else plain
        if plain in legal:
            raise EmitError(f"functions {legal[plain]} and {name} would both be called {plain}; rename one of them")
        legal[plain] = name
    return list(legal)


OWN = re.compile(
    r"^(?:SYMDYN_[A-Z]+ )*static [^;=(\n]*?(\w+)(?:\(|\[)"
    r"|^SYMDYN_WITHIN [^;=(\n]*?(\w+)\("
    r"|^typedef [^;{\n]*?(\w+) __attribute__"
    r"|^\} (\w+);$",
    re.MULTILINE,
)
"""What begins a line outside of functions: functions and tables that are static, types."""

MACRO = re.compile(r"^#define (SYMDYN_[A-Z]+)\b", re.MULTILINE)

COMMENT = r"/\*.*?\*/"


def checked(text: str, public: Collection[str]) -> str:
    """Return a source file whose functions for callers are called as none of its own.

    Raises:
        EmitError: one is; what would work.
    """
    _own_names(text, public)
    return text


def lone_header(body: str, public: Collection[str], values: Mapping[str, Any]) -> str:
    """Return the header that is all of a module; `body` is what would be its source file, without heads.

    Raises:
        EmitError: a function for callers is called as one of the file's own.
    """
    others = {name: f"{values['stem']}_own_{name}" for name in _own_names(body, public)}
    others["restrict"] = "SYMDYN_RESTRICT"
    words = "|".join(others)
    body = re.sub(rf"{COMMENT}|\b({words})\b", lambda found: others.get(found[0], found[0]), body, flags=re.DOTALL)
    macros = ["SYMDYN_RESTRICT"] * ("SYMDYN_RESTRICT" in body) + [*dict.fromkeys(MACRO.findall(body))]
    taken_back = [one for one in macros if not re.search(rf"^#undef {one}$", body, re.MULTILINE)]
    pragmas = "#pragma GCC diagnostic" in body
    return render("c/lone.h.jinja", {**values, "body": body, "macros": taken_back, "pragmas": pragmas})


def _own_names(text: str, public: Collection[str]) -> list[str]:
    """Return what a file defines outside of functions for itself, in order; `public` is for callers."""
    text = re.sub(rf"^static inline void (?:{'|'.join(public)})\(", "", text, flags=re.MULTILINE)
    found = dict.fromkeys(next(filter(None, one)) for one in OWN.findall(text))
    for name in public:
        if name in found:
            raise EmitError(
                f"{name} would be a function for callers, and is what the C file calls one of its own; "
                "rename the scene or what it is called after"
            )
    return list(found)
