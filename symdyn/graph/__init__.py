"""The expression graph: operations, hash-consed nodes, evaluation, differentiation. Knows no mechanics."""

from symdyn.graph.differentiate import Slopes, copy_node, gradient, jacobian, operands, substitute, tangents
from symdyn.graph.evaluate import Algebra, Arithmetic, arithmetic, evaluate, reachable, repeated
from symdyn.graph.expression import Expr, Graph, Scalar
from symdyn.graph.growing import growing
from symdyn.graph.identities import LinearForm, linear_form
from symdyn.graph.ops import ARITY, FUNCTIONS, Op
from symdyn.graph.pythagoras import as_number
from symdyn.graph.turns import turns

__all__ = [
    "ARITY",
    "FUNCTIONS",
    "Algebra",
    "Arithmetic",
    "Expr",
    "Graph",
    "LinearForm",
    "Op",
    "Scalar",
    "Slopes",
    "arithmetic",
    "as_number",
    "copy_node",
    "evaluate",
    "gradient",
    "growing",
    "jacobian",
    "linear_form",
    "operands",
    "reachable",
    "repeated",
    "substitute",
    "tangents",
    "turns",
]
