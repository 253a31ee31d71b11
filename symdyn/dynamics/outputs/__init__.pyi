"""Names that `symdyn.dynamics.outputs` offers; each is imported when it is first used."""

from .base_columns import BaseColumns as BaseColumns, Linear as Linear
from .count import Counts as Counts
from .derivative_outputs import differentiable as differentiable, kinks as kinks
from .named_functions import DIRECTIONS as DIRECTIONS, arguments as arguments
from .reaction_outputs import unique as unique
from .recursive_derivatives import inverse_derivatives as inverse_derivatives
from .signal_outputs import Moving as Moving, reaction_names as reaction_names
from .tangent_space import COLUMNS as COLUMNS
from .written_decisions import WrittenDecisions as WrittenDecisions
