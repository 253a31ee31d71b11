"""The header of C++ for doubles, compiled by g++ as our C is by gcc, called one state a call and with many."""

from __future__ import annotations

import ctypes
from ctypes import CDLL
from typing import Any

import numpy as np
from cases import Case
from harness import Timed
from native import address, compiled, loops
from peers.ours_c import flags, lengths, longs, padded

from symdyn.emit import Entries, emit
from tools.ours import MANY, many


def version() -> str:
    """Return how the header is compiled."""
    return f"g++ -std=gnu++17 {' '.join(flags())}"


def timed(case: Case) -> list[Timed]:
    """Return inverse dynamics, one state a call and of many."""
    made = Entries.of(emit(case.programs["inverse_dynamics"], "cpp", option="batch"))
    header, calls = made.files.items()
    text = calls[1].replace(f'#include "{header[0]}"', header[1])
    library = CDLL(str(compiled(text, (*flags(), "-std=gnu++17"), "g++")))
    one, _, rows = (getattr(library, name) for name in made.symbols.values())
    return [one_state(case, "cpp", one), many_states(case, "cpp, rows", rows)]


def one_state(case: Case, peer: str, function: Any) -> Timed:
    """Return inverse dynamics by a function of C, of three addresses and that of its result."""
    output = "inverse_dynamics"
    clock, call = loops(), ctypes.cast(function, ctypes.c_void_p)
    arguments = padded([np.ascontiguousarray(case.states[a]) for a in case.arguments(output)])
    states, size = case.references[output].shape
    out = np.zeros((states, size))
    entries = lengths(arguments)

    def sweep(sweeps: int) -> float:
        places = [address(a) for a in arguments]
        return clock.time_states(call, 3, *longs(states, sweeps), entries, *longs(size), *places, address(out))

    def result() -> np.ndarray:
        sweep(1)
        return out

    return Timed(case.name, output, peer, "state", states, sweep, result)


def many_states(case: Case, peer: str, function: Any) -> Timed:
    """Return inverse dynamics of rows of states by a function of C, of a count and four addresses."""
    output = "inverse_dynamics"
    clock, call = loops(), ctypes.cast(function, ctypes.c_void_p)
    arguments, known = many(case, output), len(case.references[output])
    out = np.zeros((MANY, case.references[output].shape[1]))

    def sweep(sweeps: int) -> float:
        places = [address(a) for a in padded(arguments)]  # of arrays that live as long as this function
        return clock.time_batch(call, 3, *longs(MANY, sweeps), *places, address(out))

    def result() -> np.ndarray:
        sweep(1)
        return out[:known]

    return Timed(case.name, output, peer, "batch", MANY, sweep, result)
