"""Names that `symdyn.emit.code` offers; each is imported when it is first used."""

from .for_sympy import SYMPY as SYMPY
from .identifiers import page_stem as page_stem, stem as stem
from .real import REALS as REALS, SINGLE as SINGLE, Real as Real
from .short_sines import ShortSines as ShortSines
