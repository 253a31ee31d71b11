"""Names that `symdyn.linear` offers; each is imported when it is first used."""

from .equilibrium import Equilibria as Equilibria, Equilibrium as Equilibrium
from .evolution import Sampled as Sampled, sampled as sampled
from .linearization import (
    Linearization as Linearization,
    Point as Point,
    Stability as Stability,
    stability as stability,
)
from .linearized import (
    linearize as linearize,
    linearize_along as linearize_along,
    linearize_at_rest as linearize_at_rest,
    locus_over as locus_over,
    rests as rests,
    systems as systems,
)
from .locus import root_locus as root_locus
from .modes import Mode as Mode, Spectrum as Spectrum, animate_modes as animate_modes
from .regulator import Axis as Axis, Observer as Observer, Regulator as Regulator, kalman as kalman, lqr as lqr
from .steady import steady_at_start as steady_at_start
from .system import System as System, SystemsFile as SystemsFile
from .transfer import (
    Bode as Bode,
    Reach as Reach,
    bode as bode,
    controllability as controllability,
    observability as observability,
    shown as shown,
    transfers as transfers,
)
