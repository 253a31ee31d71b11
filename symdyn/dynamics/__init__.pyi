"""Names that `symdyn.dynamics` offers; each is imported when it is first used."""

from .closed_forms.closed_form import ClosedForm as ClosedForm, closed_form as closed_form
from .closed_forms.coefficient_key import coefficients as coefficients
from .closed_forms.constraint_forms import (
    ClosedRow as ClosedRow,
    angle_groups as angle_groups,
    closed_constraints as closed_constraints,
)
from .closed_forms.frames_and_parameters import (
    base_parameter_forms as base_parameter_forms,
    base_parameters as base_parameters,
    chosen_frames as chosen_frames,
    formulas as formulas,
)
from .loops.closed_positions import assemble as assemble, consistent as consistent, follow as follow
from .loops.partition import LoopChoices as LoopChoices
from .mechanism.dexterity import manipulability as manipulability, singular_values as singular_values
from .mechanism.lagrange import Energies as Energies, rotor_energy as rotor_energy
from .outputs.derive import (
    Requested as Requested,
    available as available,
    called as called,
    derive as derive,
    derive_one as derive_one,
    loop_alone as loop_alone,
)
from .outputs.named_functions import Argument as Argument, Equations as Equations, Function as Function
from .outputs.output import Formulation as Formulation, Output as Output
from .outputs.output_table import OUTPUTS as OUTPUTS
from .outputs.regressor_outputs import linear_parameters as linear_parameters
from .outputs.requests import (
    expected as expected,
    formulations_lacking as formulations_lacking,
    formulations_of as formulations_of,
    kept_in_lines as kept_in_lines,
    known_formulation as known_formulation,
    of_place as of_place,
    request_of as request_of,
    row_of as row_of,
)
from .outputs.second_derivatives import second_derivative_places as second_derivative_places
from .outputs.unique_reactions import (
    loose_reactions as loose_reactions,
    reactions_at as reactions_at,
    unique_reactions as unique_reactions,
)
from .outputs.workspace import Workspace as Workspace
from .recursive.pair_runs import PairRuns as PairRuns, PairSteps as PairSteps
from .recursive.second_order import Velocities as Velocities
from .recursive.sweeps import Pairs as Pairs, Sweep as Sweep
from .recursive.table_loops import TableLoop as TableLoop
