"""Names that `symdyn.simulation.prescribed` offers; each is imported when it is first used."""

from .courses import ForceTable as ForceTable
from .entries import Entries as Entries, read_entries as read_entries
from .forces import drive_names as drive_names
from .formulas_in_time import (
    Columns as Columns,
    in_seconds as in_seconds,
    number_of as number_of,
    parameter_values as parameter_values,
    read_formula as read_formula,
    read_number as read_number,
    read_range as read_range,
    timed as timed,
    words as words,
)
