"""Names that `symdyn.linear` offers; each is imported when it is first used."""

from .bode import Bode as Bode, bode as bode, bode_plot as bode_plot, bode_table as bode_table
from .equilibrium import Equilibria as Equilibria, Equilibrium as Equilibrium, equilibria as equilibria
from .formulas import Symbolic as Symbolic
from .linearization import Axis as Axis, Linearization as Linearization, Point as Point
from .linearized import (
    along as along,
    linearize as linearize,
    linearize_along as linearize_along,
    linearize_at_rest as linearize_at_rest,
    told_of as told_of,
)
from .locus import (
    locus_lines as locus_lines,
    locus_plot as locus_plot,
    locus_table as locus_table,
    root_locus as root_locus,
)
from .modes import Mode as Mode, Spectrum as Spectrum
from .moving import MODE_PERIOD as MODE_PERIOD, animate_modes as animate_modes
from .over_values import numbers as numbers, read_values as read_values, systems as systems
from .prepared import Prepared as Prepared, prepared as prepared
from .reach import Reach as Reach, controllability as controllability, observability as observability, shown as shown
from .record import check_record as check_record, record as record
from .regulator import Observer as Observer, Regulator as Regulator, kalman as kalman, lqr as lqr
from .report import (
    HEAD as HEAD,
    KINDS as KINDS,
    as_json as as_json,
    eigenvalue as eigenvalue,
    latex as latex,
    number as number,
    shape as shape,
    text as text,
    where as where,
)
from .run_files import read_run as read_run
from .sampled import Sampled as Sampled, along_a_step as along_a_step, sampled as sampled
from .steady import at_rest as at_rest, settled as settled, steady_next_to as steady_next_to
from .symbolic import symbolic as symbolic
from .transfer import transfers as transfers
from .verdict import Stability as Stability, stability as stability
from .weights import read_weights as read_weights
