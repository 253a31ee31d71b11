"""Generated Rust as Python callables: the module, compiled behind functions of C."""

from __future__ import annotations

from symdyn.build.c_module import Module, module_in
from symdyn.build.compiler import RUSTC
from symdyn.build.warned import check_target
from symdyn.emit import Sources


def run_rust(sources: Sources) -> Module:
    """Return the functions of sources that `emit(program, "rust")` made.

    Raises:
        BuildError: sources of another target, or the compiler's own words where it refuses them.
        MissingCompiler: there is no Rust compiler.
    """
    check_target(sources, "rust")
    return module_in(sources, RUSTC)
