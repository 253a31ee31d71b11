"""Names that `symdyn.program` offers; each is imported when it is first used."""

from .formulation import (
    choose as choose,
    choose_one as choose_one,
    formulate as formulate,
    in_lines as in_lines,
)
from .lower import RowLoop as RowLoop, count_derived as count_derived, lower as lower
from .prepare import (
    ANGULAR as ANGULAR,
    assemble as assemble,
    identifier as identifier,
    prepare as prepare,
    shared as shared,
)
from .routine import Program as Program, Routine as Routine, RoutineStep as RoutineStep
from .skipped import skipped as skipped
from .tunable import Sampling as Sampling, quaternion_places as quaternion_places, tunable as tunable
