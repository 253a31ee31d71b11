"""Names that `symdyn.linear` offers; each is imported when it is first used."""

from .compensator import Compensator as Compensator, Observer as Observer
from .equilibrium import Equilibria as Equilibria, Equilibrium as Equilibrium
from .formulas import Formulas as Formulas
from .linearization import Linearization as Linearization, Point as Point
from .linearized import (
    linearize as linearize,
    linearize_along as linearize_along,
    linearize_at_rest as linearize_at_rest,
    locus_over as locus_over,
    rests as rests,
    systems as systems,
)
from .locus import RootLocus as RootLocus, read_values as read_values, root_locus as root_locus
from .modes import Mode as Mode, Spectrum as Spectrum, animate_modes as animate_modes
from .regulator import Regulator as Regulator
from .responses import FrequencyResponse as FrequencyResponse, TimeResponse as TimeResponse
from .stability import Margins as Margins, Stability as Stability
from .state_space import StateSpace as StateSpace
from .steady import steady_at_start as steady_at_start
from .system import System as System, SystemsFile as SystemsFile, track as track
from .transfer import Reach as Reach, Transfer as Transfer, poles_in_words as poles_in_words
from .weights import Axis as Axis
