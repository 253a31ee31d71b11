"""Generated C++ as Python callables: its templates for doubles, compiled behind functions of C."""

from __future__ import annotations

from symdyn.build.c_module import Module, module_in
from symdyn.build.compiler import CPLUSPLUS
from symdyn.build.warned import check_target
from symdyn.emit import Sources


def run_cpp(sources: Sources) -> Module:
    """Return the functions of sources that `emit(program, "cpp")` made, for doubles.

    Raises:
        BuildError: sources of another target, or the compiler's own words where it refuses them.
        MissingCompiler: there is no C++ compiler.
    """
    check_target(sources, "cpp")
    return module_in(sources, CPLUSPLUS)
