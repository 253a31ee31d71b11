"""Names that `symdyn.dynamics.roads` offers; each is imported when it is first used."""

from .base_columns import base_columns as base_columns, base_of_columns as base_of_columns, base_values as base_values
from .closed_outputs import drives_of as drives_of
from .count import Counts as Counts, count_by_binding as count_by_binding
from .derivative_outputs import COLUMNS as COLUMNS, differentiable as differentiable
from .kinks import kinks as kinks
from .linear_forces import linear as linear, parameters as parameters, remainder as remainder
from .linear_loops import (
    LinearLoops as LinearLoops,
)
from .named_functions import (
    DIRECTIONS as DIRECTIONS,
    arguments as arguments,
)
from .reaction_outputs import unique as unique
from .recursive_derivatives import inverse_derivatives as inverse_derivatives
from .regressor_outputs import energies_by_momentum as energies_by_momentum
from .signal_outputs import (
    Moving as Moving,
    check_letters as check_letters,
    driven as driven,
    expressed as expressed,
    multiplier_names as multiplier_names,
    reaction_names as reaction_names,
)
from .unique_reactions import unique_entries as unique_entries
from .written_decisions import WrittenDecisions as WrittenDecisions
