"""Names that `symdyn.emit.code` offers; each is imported when it is first used."""

from .identifiers import page_stem as page_stem, stem as stem
from .spelling import REALS as REALS, SINGLE as SINGLE, SYMPY as SYMPY, Real as Real, ShortSines as ShortSines
