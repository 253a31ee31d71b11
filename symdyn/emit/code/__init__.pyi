"""Names that `symdyn.emit.code` offers; each is imported when it is first used."""

from .identifiers import page_stem as page_stem, stem as stem
from .operators import SYMPY as SYMPY
from .real import REALS as REALS, SINGLE as SINGLE, Real as Real, ShortSines as ShortSines
