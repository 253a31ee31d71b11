"""Names that `symdyn.program` offers; each is imported when it is first used."""

from .lower import (
    PairLoop as PairLoop,
    RowLoop as RowLoop,
    choose as choose,
    choose_one as choose_one,
    count_derived as count_derived,
    formulate as formulate,
    in_lines as in_lines,
    lower as lower,
)
from .routine import (
    Program as Program,
    Routine as Routine,
    RoutineStep as RoutineStep,
    assemble as assemble,
    identifier as identifier,
    prepare as prepare,
    shared as shared,
)
from .skipped import skipped as skipped
from .tunable import Sampling as Sampling, quaternion_places as quaternion_places, tunable as tunable
