"""Names that `symdyn.algebra` offers; each is imported when it is first used."""

from .balls import BITS as BITS, Balls as Balls, distance as distance
from .big import (
    AllRoundingError as AllRoundingError,
    BigFloats as BigFloats,
    Bounded as Bounded,
    LooseErrors as LooseErrors,
    RunningErrors as RunningErrors,
)
from .collect import rounded as rounded
from .compact import Compactor as Compactor
from .degree import Bound as Bound, Bounds as Bounds
from .elimination import eliminate as eliminate
from .finite_field import (
    FiniteField as FiniteField,
    Needs as Needs,
    Redraw as Redraw,
    draw_prime as draw_prime,
    evaluate_over_field as evaluate_over_field,
    function_over_field as function_over_field,
    needs as needs,
    needs_of as needs_of,
)
from .form import (
    Form as Form,
    Function as Function,
    Number as Number,
    Pi as Pi,
    Power as Power,
    Product as Product,
    Sum as Sum,
    Symbol as Symbol,
    product_of as product_of,
    sum_of as sum_of,
)
from .joined_terms import with_added_angles as with_added_angles, with_squares as with_squares
from .levels import Levels as Levels
from .many_points import ManyPoints as ManyPoints, Residues as Residues
from .midpoints import Midpoints as Midpoints, RealBalls as RealBalls, bits_of as bits_of
from .numeric import Array as Array, Batches as Batches, Floats as Floats
from .ratios import (
    Ratio as Ratio,
    Ratios as Ratios,
    characteristic as characteristic,
    factors as factors,
    number_at as number_at,
    product as product,
    solved as solved,
)
from .shaken import Shaken as Shaken
from .sums_of_angles import AngleGroup as AngleGroup, total_angles as total_angles
from .sympy_algebra import (
    NAMES as NAMES,
    form_to_sympy as form_to_sympy,
    graph_to_sympy as graph_to_sympy,
    sympy_text as sympy_text,
    sympy_to_graph as sympy_to_graph,
)
from .trigonometric import Polynomial as Polynomial, TrigonometricRing as TrigonometricRing
from .vanishing import vanishes as vanishes
