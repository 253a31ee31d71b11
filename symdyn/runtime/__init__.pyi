"""Names that `symdyn.runtime` offers; each is imported when it is first used."""

from .backends.load_functions import load as load
from .c_module import CFunction as CFunction, Module as Module, bind_rows as bind_rows, build as build
from .cache import CACHE_VARIABLE as CACHE_VARIABLE, Kept as Kept
from .commands import Commands as Commands
from .compiler import complete as complete, find_compiler as find_compiler, with_binaries as with_binaries
from .library import build_extension as build_extension, load_functions as load_functions
from .loaded import Loaded as Loaded, lambdify as lambdify, load_program as load_program
from .machine import here as here
from .numeric_function import NumericFunction as NumericFunction, Operand as Operand
from .runners import RUNNERS as RUNNERS, Runner as Runner, run_python as run_python
from .second_derivatives import SecondDerivatives as SecondDerivatives, second_derivatives as second_derivatives
