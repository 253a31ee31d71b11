"""Names that `symdyn.emit.print` offers; each is imported when it is first used."""

from .breaking import (
    aligned as aligned,
    bmatrix as bmatrix,
    lines_of as lines_of,
    matrix_width as matrix_width,
    together as together,
)
from .dalembert_page import dalembert_equations as dalembert_equations
from .dalembert_system import length_symbols as length_symbols
from .equations_of_motion import EquationsOfMotion as EquationsOfMotion, equations as equations
from .equations_text import (
    CHOICES as CHOICES,
    base_parameter_texts as base_parameter_texts,
    base_parameters_text as base_parameters_text,
    equations_text as equations_text,
)
from .formula_text import Latex as Latex, text_of as text_of, value_text as value_text
from .frames_text import frame_texts as frame_texts
from .latex_page import coefficient_name as coefficient_name, writer as writer
from .latex_width import BREAK as BREAK, LINE as LINE, latex_width as latex_width
from .letters import LENGTH as LENGTH, Letters as Letters, body_number as body_number
from .printable import Coefficient as Coefficient, Printable as Printable, printable as printable
from .printed_names import PrintName as PrintName, latex_symbols as latex_symbols, print_name as print_name
from .sympy_equations import SympyEquations as SympyEquations
from .too_long import refuse_too_long as refuse_too_long
