"""Names that `symdyn.dynamics.outputs` offers; each is imported when it is first used."""

from .arm_outputs import (
    BRANCHES as BRANCHES,
    KINDS as KINDS,
    ArmAngles as ArmAngles,
    Turn as Turn,
    arm_angles as arm_angles,
    away_from_guards as away_from_guards,
    sense as sense,
)
from .base_columns import BaseColumns as BaseColumns, Linear as Linear
from .constrained_outputs import unique as unique
from .contact_equations import (
    ContactEquations as ContactEquations,
    contact_equations as contact_equations,
    dot as dot,
)
from .contact_rows import (
    CLOSED_AT_ONCE as CLOSED_AT_ONCE,
    MODE as MODE,
    Row as Row,
    Touch as Touch,
    lacks_modes as lacks_modes,
    touching as touching,
    unilaterals_of as unilaterals_of,
    with_modes as with_modes,
)
from .derivative_outputs import differentiable as differentiable, kinks as kinks
from .named_functions import (
    DIRECTIONS as DIRECTIONS,
    POSE as POSE,
    Counts as Counts,
    arguments as arguments,
    direction as direction,
)
from .recursive_derivatives import inverse_derivatives as inverse_derivatives
from .signal_outputs import Moving as Moving, reaction_names as reaction_names
from .tangent_space import COLUMNS as COLUMNS
from .written_decisions import WrittenDecisions as WrittenDecisions
