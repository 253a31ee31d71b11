"""Names that `symdyn.scene.values` offers; each is imported when it is first used."""

from .dimension import (
    BASE as BASE,
    FORCE_UNITS as FORCE_UNITS,
    TIME as TIME,
    force_unit as force_unit,
    product as product,
)
from .folding import add as add, neg as neg
from .formula import split_commas as split_commas
from .grammar import (
    GREEK as GREEK,
    LatexError as LatexError,
    read_latex as read_latex,
    takes_exponent as takes_exponent,
)
from .key import TIMED as TIMED
from .made_names import moving_names as moving_names
from .mapping import map_quantities as map_quantities, quantities_in as quantities_in, substituted as substituted
from .model import Letter as Letter
from .names import (
    C_KEYWORDS as C_KEYWORDS,
    FORMULA_NAMES as FORMULA_NAMES,
    LONGEST as LONGEST,
    check_scene_name as check_scene_name,
    choice as choice,
    listed as listed,
    nearest as nearest,
    suggestion as suggestion,
)
from .quantity import NULL as NULL, ZERO as ZERO, Vector as Vector
from .signals import (
    AXES as AXES,
    COLUMNS as COLUMNS,
    COMPONENTS as COMPONENTS,
    LOOSE as LOOSE,
    MULTIPLIER as MULTIPLIER,
    REACTION as REACTION,
)
from .spelling import spell_fraction as spell_fraction
from .table import Faults as Faults, shorten as shorten, show as show, shown as shown
from .texts import in_language as in_language
from .tolerance import read_tolerance as read_tolerance
from .unit import Unit as Unit, UnitError as UnitError, misfit as misfit, read_unit as read_unit
from .value import Value as Value, known_value as known_value, value_of as value_of
from .with_unit import fits as fits
