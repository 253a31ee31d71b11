"""Names that `symdyn.graph` offers; each is imported when it is first used."""

from .differentiate import (
    Slopes as Slopes,
    copy_node as copy_node,
    gradient as gradient,
    jacobian as jacobian,
    operands as operands,
    substitute as substitute,
    tangents as tangents,
)
from .evaluate import (
    Algebra as Algebra,
    Arithmetic as Arithmetic,
    arithmetic as arithmetic,
    evaluate as evaluate,
    reachable as reachable,
    repeated as repeated,
)
from .expression import Expr as Expr, Graph as Graph, Scalar as Scalar
from .growing import growing as growing
from .identities import SMALL_PRIMES as SMALL_PRIMES, LinearForm as LinearForm, linear_form as linear_form
from .ops import (
    ADD as ADD,
    ARITY as ARITY,
    CONSTANT as CONSTANT,
    DIV as DIV,
    FUNCTIONS as FUNCTIONS,
    MUL as MUL,
    NEG as NEG,
    PI as PI,
    SUB as SUB,
    SYMBOL as SYMBOL,
    Op as Op,
)
from .pythagoras import as_number as as_number
from .turns import turns as turns
