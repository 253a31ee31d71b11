"""Names in generated code: legal where they stand, and never taken already."""

from __future__ import annotations

import keyword
import re
import sys
from collections.abc import Collection, Sequence
from functools import cache

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
