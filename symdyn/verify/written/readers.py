"""Which files of a target are read, by the ends of their names."""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.verify.written.c import C_BY_COLUMNS, C
from symdyn.verify.written.cpp import CPP
from symdyn.verify.written.javascript import JAVASCRIPT
from symdyn.verify.written.julia import JULIA
from symdyn.verify.written.kernels import CUDA, OPENCL
from symdyn.verify.written.matlab import MATLAB
from symdyn.verify.written.python import CASADI, HEYOKA, NUMPY
from symdyn.verify.written.reading import ReadLanguage
from symdyn.verify.written.rust import RUST

READERS: Mapping[str, Mapping[str, ReadLanguage]] = {
    "numpy": {".py": NUMPY},
    "c": {".c": C, ".h": C},
    "js": {".mjs": JAVASCRIPT, ".js": JAVASCRIPT},
    "casadi": {".py": CASADI, ".c": C},
    "heyoka": {".py": HEYOKA},
    "matlab": {".m": MATLAB},
    "cpp": {".hpp": CPP},
    "julia": {".jl": JULIA},
    "rust": {".rs": RUST},
    "gpu": {".cu": CUDA, ".cl": OPENCL},
}
"""Target: ending of a file: what it is read as. Other files of a target are fixed text."""

OTHERWISE: Mapping[tuple[str, str], Mapping[str, ReadLanguage]] = {
    ("matlab", "mex"): {".c": C_BY_COLUMNS, ".h": C},  # its .m files hand on what they are given
}
"""Target and option whose files are read otherwise."""


def languages(target: str, option: str) -> Mapping[str, ReadLanguage]:
    """Return what the files of a target with an option are read as, by the ends of their names."""
    return OTHERWISE.get((target, option), READERS[target])
