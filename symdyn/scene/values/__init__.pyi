"""Names that `symdyn.scene.values` offers; each is imported when it is first used."""

from .dimension import (
    force_unit as force_unit,
)
from .formula import split_commas as split_commas
from .grammar import (
    GREEK as GREEK,
    letters_of as letters_of,
    takes_exponent as takes_exponent,
)
from .key import TIMED as TIMED
from .mapping import quantities_in as quantities_in, substituted as substituted
from .model import Letter as Letter
from .names import (
    LONGEST as LONGEST,
    RESERVED as RESERVED,
    choice as choice,
    listed as listed,
    nearest as nearest,
    suggestion as suggestion,
)
from .quantity import ZERO as ZERO
from .signals import LETTERS as LETTERS
from .table import Faults as Faults, shorten as shorten, show as show
from .texts import in_language as in_language
from .tolerance import read_tolerance as read_tolerance
from .unit import Unit as Unit, UnitError as UnitError
from .value import known_value as known_value, value_of as value_of
from .with_unit import fits as fits
