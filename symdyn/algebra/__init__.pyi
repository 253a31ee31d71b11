"""Names that `symdyn.algebra` offers; each is imported when it is first used."""

from .big import (
    AllRoundingError as AllRoundingError,
    Balls as Balls,
    BigFloats as BigFloats,
    Bounded as Bounded,
    Midpoints as Midpoints,
    RealBalls as RealBalls,
    RunningErrors as RunningErrors,
)
from .compact import Compactor as Compactor, with_added_angles as with_added_angles, with_squares as with_squares
from .constants import constants as constants, is_simple as is_simple
from .finite_field import FiniteField as FiniteField, ManyPoints as ManyPoints, Needs as Needs, Redraw as Redraw
from .form import (
    Form as Form,
    Function as Function,
    Number as Number,
    Pi as Pi,
    Power as Power,
    Product as Product,
    Sum as Sum,
    Symbol as Symbol,
)
from .generators import refused as refused
from .numeric import Array as Array, Batches as Batches, Floats as Floats
from .ratios import Nodes as Nodes, Ratio as Ratio, Ratios as Ratios
from .sums_of_angles import AngleGroup as AngleGroup, rounded as rounded
from .sympy_algebra import NAMES as NAMES, graph_to_sympy as graph_to_sympy, shared_to_sympy as shared_to_sympy
from .trigonometric import Polynomial as Polynomial, TrigonometricRing as TrigonometricRing
