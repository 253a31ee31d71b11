"""Names that `symdyn.emit.print` offers; each is imported when it is first used."""

from .arm_page import ArmStep as ArmStep, arm_steps as arm_steps
from .breaking import (
    BREAK as BREAK,
    BMatrix as BMatrix,
    Line as Line,
    latex_width as latex_width,
    refuse_too_long as refuse_too_long,
)
from .contact_page import Percussion as Percussion, percussions as percussions
from .dalembert_page import length_symbols as length_symbols
from .equations_text import (
    EquationsOfMotion as EquationsOfMotion,
    base_parameter_texts as base_parameter_texts,
    equations as equations,
    printed_text as printed_text,
)
from .formula_text import Latex as Latex, text_of as text_of, value_text as value_text
from .formulation_groups import EquationGroup as EquationGroup, EquationRow as EquationRow
from .formulations_page import FormulationPage as FormulationPage
from .printable import Coefficient as Coefficient, Printable as Printable
from .printed_names import Letters as Letters, PrintName as PrintName, latex_symbols as latex_symbols
from .sympy_equations import SympyEquations as SympyEquations
