"""Names that `symdyn.emit.print` offers; each is imported when it is first used."""

from .breaking import BMatrix as BMatrix, Line as Line
from .dalembert_system import length_symbols as length_symbols
from .equations_of_motion import EquationsOfMotion as EquationsOfMotion, equations as equations
from .equations_text import (
    base_parameter_texts as base_parameter_texts,
    printed_text as printed_text,
)
from .formula_text import Latex as Latex, text_of as text_of, value_text as value_text
from .latex_width import BREAK as BREAK, latex_width as latex_width
from .letters import Letters as Letters
from .printable import Coefficient as Coefficient, Printable as Printable
from .printed_names import PrintName as PrintName, latex_symbols as latex_symbols
from .sympy_equations import SympyEquations as SympyEquations
from .too_long import refuse_too_long as refuse_too_long
