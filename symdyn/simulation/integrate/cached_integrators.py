"""heyoka's integrators, kept in the cache between processes: compiled code, which belongs to one processor.

What a name is made of: heyoka's version, the processor, the expressions as heyoka pickles them, and its options.
"""

from __future__ import annotations

import hashlib
import pickle
import platform
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from symdyn.runtime import Kept
from symdyn.simulation.integrate.heyoka_expressions import library

SUFFIX = ".heyoka"

MOST = 64
"""Integrators that are kept, of a few hundred kB each."""


def integrator(expressions: Sequence[Any], options: Mapping[str, Any], make: Callable[[], Any]) -> Any:
    """Return an integrator of expressions with options: the one that is kept, or the one that `make` compiles.

    The caller sets its state, time and parameters, which are those that it was made with.
    """
    kept = Kept(_name(expressions, options))
    content = kept.content()
    if content is not None:
        with suppress(Exception):  # a heyoka of the same version that was built otherwise
            return pickle.loads(content)  # our own bytes: folder, owner and hash were looked at
    made = make()
    kept.keep(pickle.dumps(made), MOST)
    return made


def _name(expressions: Sequence[Any], options: Mapping[str, Any]) -> str:
    digest = hashlib.sha256()
    about = (library().__version__, platform.python_version(), *processor(), repr(sorted(options.items())))
    for part in (*(one.encode() for one in about), pickle.dumps(list(expressions))):
        digest.update(f"{len(part)}:".encode() + part)
    return f"integrator-{digest.hexdigest()[:24]}{SUFFIX}"


@cache
def processor() -> tuple[str, ...]:
    """Return what tells processors apart that run different code: model and features, else the machine's own name."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return (*platform.uname(),)
    told = ("model name", "flags", "Features", "CPU part", "isa", "uarch", "cpu")
    return (platform.machine(), *sorted({line for line in lines if line.partition(":")[0].strip() in told}))
