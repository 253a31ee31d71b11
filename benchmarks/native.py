"""Compiling what the benchmark needs besides the generated code; libraries are kept in build/bench by their content."""

from __future__ import annotations

import ctypes
import hashlib
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

FOLDER = Path(__file__).parent.parent / "build" / "bench"

HERE = Path(__file__).parent

NATIVE = ("-O3", "-march=native", "-ffp-contract=fast", "-fPIC")
"""For everybody's code: ours and that of peers whose generators leave compiling to the user."""

MORE: list[str] = []
"""Flags that everything is compiled with after its own, ours and the peers'; `run.py --flags` fills them in."""


class MissingError(Exception):
    """A peer cannot be measured here; the words say why."""


def compiled(
    source: Path | str, flags: Sequence[str], compiler: str = "gcc", library: bool = True, more: Sequence[str] = ()
) -> Path:
    """Return the library or program that a source makes, compiled unless that was done before.

    Args:
        source: a file, or C text.
        flags: of the command line, before the source.
        compiler: to run.
        library: whether a shared library is made, else a program.
        more: of the command line, after the source, such as libraries.

    Raises:
        MissingError: there is no such compiler, or it refuses.
    """
    text = source if isinstance(source, str) else source.read_text("utf-8")
    headers = [] if isinstance(source, str) else sorted(source.parent.glob("*.hpp"))
    flags = (*flags, *MORE)
    parts = [text, compiler, *flags, *more, *(path.read_text("utf-8") for path in headers)]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]
    FOLDER.mkdir(parents=True, exist_ok=True)
    stem = "code" if isinstance(source, str) else source.stem
    target = FOLDER / f"{stem}-{key}{'.so' if library else ''}"
    if target.is_file():
        return target
    if isinstance(source, str):
        path = FOLDER / f"{stem}-{key}.c"
        path.write_text(text, "utf-8")
    else:
        path = source
    aside = target.with_suffix(".new")
    kind = ("-shared",) if library else ()
    command = [compiler, *flags, *kind, str(path), "-o", str(aside), *more, "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as fault:
        raise MissingError(f"{compiler} cannot be run ({fault.strerror})") from fault
    if done.returncode:
        first = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr[:200])
        raise MissingError(f"{compiler} refuses {path.name}: {first}")
    aside.replace(target)
    return target


def address(array: npt.NDArray[np.float64]) -> ctypes.c_void_p:
    """Return where the entries of an array are."""
    return ctypes.c_void_p(array.ctypes.data)


def loops() -> ctypes.CDLL:
    """Return the timing loops of calls.c."""
    library = ctypes.CDLL(str(compiled(HERE / "calls.c", ("-O2", "-fPIC"), more=("-lpthread",))))
    for name in ("time_states", "time_batch", "time_casadi", "time_threads", "time_filling"):
        getattr(library, name).restype = ctypes.c_double
    return library
