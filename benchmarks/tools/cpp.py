"""The header of C++ for doubles, compiled by g++ as our C is by gcc, called one state a call."""

from __future__ import annotations

import ctypes
from ctypes import CDLL
from typing import Any

import numpy as np
from cases import Case
from harness import Timed
from native import address, compiled, loops
from peers.ours_c import flags, lengths, longs, padded

from symdyn.build.run_cpp import with_calls
from symdyn.emit import emit


def version() -> str:
    """Return how the header is compiled."""
    return f"g++ -std=gnu++17 {' '.join(flags())}"


def timed(case: Case) -> list[Timed]:
    """Return inverse dynamics, one state a call."""
    files, (name,) = with_calls(emit(case.programs["inverse_dynamics"], "cpp"))
    header, calls = files.items()
    text = calls[1].replace(f'#include "{header[0]}"', header[1])
    library = CDLL(str(compiled(text, (*flags(), "-std=gnu++17"), "g++")))
    return [one_state(case, "cpp", getattr(library, name))]


def one_state(case: Case, peer: str, function: Any) -> Timed:
    """Return inverse dynamics by a function of C, of three addresses and that of its result."""
    output = "inverse_dynamics"
    clock, call = loops(), ctypes.cast(function, ctypes.c_void_p)
    arguments = padded([np.ascontiguousarray(case.states[a]) for a in case.arguments(output)])
    states, size = case.references[output].shape
    out = np.zeros((states, size))
    entries, places = lengths(arguments), [address(a) for a in arguments]

    def sweep(sweeps: int) -> float:
        return clock.time_states(call, 3, *longs(states, sweeps), entries, *longs(size), *places, address(out))

    def result() -> np.ndarray:
        sweep(1)
        return out

    return Timed(case.name, output, peer, "state", states, sweep, result)
