"""Names that `symdyn.graph` offers; each is imported when it is first used."""

from .differentiate import (
    Algebra as Algebra,
    Arithmetic as Arithmetic,
    LocalPartials as LocalPartials,
    arithmetic as arithmetic,
    evaluate as evaluate,
    gradient as gradient,
    operands as operands,
    reachable as reachable,
    repeated as repeated,
    substitute as substitute,
    tangents as tangents,
)
from .expression import Expr as Expr, Graph as Graph, Scalar as Scalar, growing as growing
from .ops import ELEMENTARY as ELEMENTARY, SMALL_PRIMES as SMALL_PRIMES, Op as Op
from .piecewise import Piecewise as Piecewise
