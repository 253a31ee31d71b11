"""Names that `symdyn.program` offers; each is imported when it is first used."""

from .assemble import ANGULAR as ANGULAR, assemble as assemble, identifier as identifier, shared as shared
from .constants import constants as constants
from .formulation import (
    candidates as candidates,
    cheapest as cheapest,
    choose as choose,
    chosen as chosen,
    formulate as formulate,
    kept_in_lines as kept_in_lines,
    known_road as known_road,
    looped as looped,
)
from .in_lines import in_lines as in_lines
from .lower import at_rest as at_rest, count_derived as count_derived, lower as lower
from .prepare import PREPARE as PREPARE, prepare as prepare
from .routine import PARAMS as PARAMS, PREPARED as PREPARED, Program as Program, Routine as Routine, Step as Step
from .row_loop import RowLoop as RowLoop, row_loop as row_loop
from .skipped import skipped as skipped
from .states import (
    ALLOWED as ALLOWED,
    WIDER as WIDER,
    quaternion_places as quaternion_places,
    sample as sample,
    samples as samples,
)
from .table_numbers import MOMENTS as MOMENTS, table_in_order as table_in_order, table_numbers as table_numbers
from .tunable import tunable as tunable
