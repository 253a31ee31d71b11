"""Names that `symdyn.dynamics` offers; each is imported when it is first used."""

from .closed_forms.closed_form import ClosedForm as ClosedForm, closed_form as closed_form
from .closed_forms.coefficient_key import coefficients as coefficients
from .closed_forms.constraint_forms import ClosedRow as ClosedRow, closed_constraints as closed_constraints
from .closed_forms.frames_and_parameters import (
    base_parameter_forms as base_parameter_forms,
    base_parameters as base_parameters,
    chosen_frames as chosen_frames,
    formulas as formulas,
)
from .closed_forms.parallel import angle_groups as angle_groups
from .lagrange.second_kind import Energies as Energies, rotor_energy as rotor_energy
from .loops.continuation import assemble as assemble, consistent as consistent, follow as follow
from .loops.partition import LoopChoices as LoopChoices
from .recursive.sweeps import Sweep as Sweep
from .recursive.table_loops import TableLoop as TableLoop
from .roads.derive import called as called, derive as derive, derive_one as derive_one, loop_alone as loop_alone
from .roads.named_functions import Argument as Argument, Equations as Equations, Function as Function
from .roads.output import Output as Output, Road as Road, Unasked as Unasked
from .roads.outputs import OUTPUTS as OUTPUTS
from .roads.regressor_outputs import linear_parameters as linear_parameters
from .roads.requests import (
    expected as expected,
    kept_in_lines as kept_in_lines,
    known_road as known_road,
    looped as looped,
    of_place as of_place,
    request_of as request_of,
    roads_lacking as roads_lacking,
    roads_of as roads_of,
    row_of as row_of,
)
from .roads.unique_reactions import (
    loose_reactions as loose_reactions,
    reactions_at as reactions_at,
    unique_reactions as unique_reactions,
)
from .roads.wanted import Wanted as Wanted, available as available
from .roads.workspace import Workspace as Workspace
