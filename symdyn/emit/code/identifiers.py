"""Names in generated code: legal where they stand, and never taken already."""

from __future__ import annotations

import keyword
import re
import sys
from collections.abc import Collection, Sequence

from symdyn.errors import EmitError
from symdyn.program import identifier

C_HEADERS = """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg stdbool
stddef stdint stdio stdlib string tgmath time wchar wctype"""

MATLAB = """case catch classdef elseif end endfor endfunction endif endparfor endswitch endwhile function otherwise
parfor persistent spmd until unwind_protect"""
"""Words that no package of MATLAB or Octave can have, and no name of C or Python has yet."""

DEVICES = re.compile(r"(con|prn|aux|nul|(com|lpt)\d)\Z", re.IGNORECASE)


def stem(scene: str) -> str:
    """Return the file name of a scene without its ending, which also opens the names of its C functions.

    A scene called numpy or math would hide the module or header that its own code needs, a package of MATLAB is not
    called end, and Windows writes no file called CON.c; each gets an underscore.
    """
    name = identifier(scene) or "scene"
    if not name[0].isalpha():
        name = f"m{name}"
    module = name == "numpy" or keyword.iskeyword(name) or name in sys.stdlib_module_names
    return f"{name}_" if module or name in (*C_HEADERS.split(), *MATLAB.split()) or is_device(name) else name


def page_stem(scene: str) -> str:
    """Return the file name of a scene's pages without ending; that of a device of Windows gets an underscore."""
    return f"{scene}_" if is_device(scene) else scene


def is_device(name: str) -> bool:
    """Tell whether Windows takes a file of this name, with any ending, for a device."""
    return DEVICES.match(name) is not None


def function_names(names: Sequence[str], keywords: Collection[str] = ()) -> list[str]:
    """Return legal names for functions, in order; one of the target's keywords gets an underscore.

    Raises:
        EmitError: two of them become one.
    """
    legal: dict[str, str] = {}
    for name in names:
        plain = identifier(name)
        plain = f"{plain}_" if plain in keywords else plain
        if plain in legal:
            raise EmitError(f"functions {legal[plain]} and {name} would both be called {plain}; rename one of them")
        legal[plain] = name
    return list(legal)
