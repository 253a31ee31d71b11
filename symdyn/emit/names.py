"""Names in generated code: legal in every target, and never taken already."""

from __future__ import annotations

import keyword
import sys
from collections.abc import Sequence

from symdyn.errors import EmitError
from symdyn.program import identifier

C_HEADERS = """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg stdbool
stddef stdint stdio stdlib string tgmath time wchar wctype"""


def stem(scene: str) -> str:
    """Return the file name of a scene without its ending, which also opens the names of its C functions.

    A scene called numpy or math would hide the module or header that its own code needs; it gets an underscore.
    """
    name = identifier(scene) or "scene"
    if not name[0].isalpha():
        name = f"m{name}"
    taken = name in C_HEADERS.split() or name == "numpy" or keyword.iskeyword(name) or name in sys.stdlib_module_names
    return f"{name}_" if taken else name


def function_names(names: Sequence[str]) -> list[str]:
    """Return legal names for functions, in order.

    Raises:
        EmitError: two of them become one.
    """
    legal: dict[str, str] = {}
    for name in names:
        plain = identifier(name)
        if plain in legal:
            raise EmitError(f"functions {legal[plain]} and {name} would both be called {plain}; rename one of them")
        legal[plain] = name
    return list(legal)
