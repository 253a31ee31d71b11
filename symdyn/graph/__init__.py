"""The expression graph: operations, hash-consed nodes, evaluation, differentiation. Knows no mechanics."""

from symdyn.graph.differentiate import copy_node, gradient, substitute, tangents
from symdyn.graph.evaluate import Algebra, Arithmetic, arithmetic, evaluate, reachable
from symdyn.graph.expression import Expr, Graph, Scalar
from symdyn.graph.growing import growing
from symdyn.graph.identities import LinearForm, linear_form
from symdyn.graph.ops import ARITY, FUNCTIONS, Op

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
    "arithmetic",
    "copy_node",
    "evaluate",
    "gradient",
    "growing",
    "linear_form",
    "reachable",
    "substitute",
    "tangents",
]
