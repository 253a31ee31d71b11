"""Names that stand outside of functions: those for callers, and a file's own, which nobody else must meet.

    <stem>_<function>         for callers
    <stem>_own_<name>         a header's own functions, types and tables, which may stand beside those of others
    SYMDYN_<NAME>             macros; a header takes them back in its end
    SYMDYN_<stem>_H           the guard of a header, in the letters of the scene: Arm and arm are two

In a source file, which is a translation unit, what is its own is called by its name alone.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any

from symdyn.emit.render import render
from symdyn.errors import EmitError

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
