"""The module of Rust, compiled by rustc for this machine, called one state a call and with many."""

from __future__ import annotations

from cases import Case
from harness import Timed

from symdyn.emit import emit
from symdyn.runtime import find_compiler
from symdyn.runtime.c_module import run_rust
from symdyn.runtime.commands import RUST
from symdyn.runtime.compiler import RUSTC
from tools.cpp import many_states, one_state


def version() -> str:
    """Return how the module is compiled."""
    compiler = find_compiler(language=RUSTC)
    return f"{compiler.version.splitlines()[0]}, {' '.join((*RUST.flags, *compiler.machine))}"


def timed(case: Case) -> list[Timed]:
    """Return inverse dynamics, one state a call and of many."""
    call = run_rust(emit(case.programs["inverse_dynamics"], "rust", option="batch")).inverse_dynamics
    return [one_state(case, "rust", call._call), many_states(case, "rust, rows", call._rows)]
