"""Names that `symdyn.emit` offers; each is imported when it is first used."""

from .code.target import Draft as Draft, Sources as Sources, Target as Target
from .escape import (
    in_code as in_code,
    in_html as in_html,
    in_latex as in_latex,
    in_markdown as in_markdown,
    in_script as in_script,
    in_script_code as in_script_code,
)
from .render import render as render, verbatim as verbatim
from .targets.c.c99 import BATCH as BATCH, HEADER_ONLY as HEADER_ONLY, C as C
from .targets.c.dd_functions import DD_LANES as DD_LANES
from .targets.c.double_double import LIMIT_EXPONENT as LIMIT_EXPONENT
from .targets.c.gathered import LANES as LANES
from .targets.casadi.module import CASADI as CASADI
from .targets.cpp import CPP as CPP, namespace as namespace
from .targets.door import TARGETS as TARGETS, beside as beside, emit as emit
from .targets.fmu.archive import members as members, packed as packed
from .targets.fmu.functional_mockup import FMU as FMU
from .targets.gpu.cuda_opencl import GPU as GPU
from .targets.gpu.kernels import rooms as rooms
from .targets.gpu.launchers import launchers as launchers
from .targets.heyoka import HEYOKA as HEYOKA
from .targets.javascript import JS as JS
from .targets.json_graph import JSON as JSON
from .targets.json_reader import read_program as read_program
from .targets.later import (
    RUNTIME as RUNTIME,
    Code as Code,
    Entry as Entry,
    fits_float as fits_float,
    runtime as runtime,
    runtime_code as runtime_code,
    runtime_templates as runtime_templates,
)
from .targets.matlab import FLAGS as FLAGS, MATLAB as MATLAB, MEX as MEX
from .targets.numpy import NUMPY as NUMPY
from .targets.rust.module import RUST as RUST, TYPES as TYPES
from .targets.ufunc import DOUBLES as DOUBLES, UFUNC as UFUNC, docstrings as docstrings
from .targets.wasm import WASM as WASM
from .targets.xla import (
    COLUMNS as COLUMNS,
    WEIGHTED as WEIGHTED,
    card_handlers as card_handlers,
    handler as handler,
    handlers as handlers,
)
from .writing import Contents as Contents, write as write, write_file as write_file
