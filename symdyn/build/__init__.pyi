"""Names that `symdyn.build` offers; each is imported when it is first used."""

from .backends.door import load as load
from .c_module import CFunction as CFunction, Module as Module, bind_rows as bind_rows, build as build
from .commands import COMMANDS as COMMANDS, Commands as Commands
from .compiler import (
    CPLUSPLUS as CPLUSPLUS,
    RUSTC as RUSTC,
    find_compiler as find_compiler,
    try_compiler as try_compiler,
)
from .complete import complete as complete
from .entry import distrust as distrust
from .extension import build_extension as build_extension, python_headers as python_headers
from .folder import CACHE_VARIABLE as CACHE_VARIABLE, cache_folder as cache_folder, trusted_folder as trusted_folder
from .kept import keep as keep, kept as kept
from .library import load_functions as load_functions
from .loaded import (
    Loaded as Loaded,
    is_large as is_large,
    lambdify as lambdify,
    load_program as load_program,
    loaded as loaded,
)
from .mockup_binary import with_binaries as with_binaries
from .numeric_function import NumericFunction as NumericFunction, Operand as Operand
from .run_node import NODE_COMMANDS as NODE_COMMANDS
from .run_octave import OCTAVE_COMMANDS as OCTAVE_COMMANDS
from .runners import RUNNERS as RUNNERS, Runner as Runner, run_python as run_python
from .warned import warn as warn
