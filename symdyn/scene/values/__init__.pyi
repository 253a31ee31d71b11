"""Names that `symdyn.scene.values` offers; each is imported when it is first used."""

from .body import OUTLINES as OUTLINES, Body as Body, Pose as Pose
from .dimension import (
    force_unit as force_unit,
)
from .element import Contact as Contact, Element as Element, Load as Load, Place as Place, Strut as Strut
from .entry import Faults as Faults, shorten as shorten, show as show
from .formula import split_commas as split_commas
from .grammar import (
    GREEK as GREEK,
    LatexSymbol as LatexSymbol,
)
from .joint import Joint as Joint, acceleration_name as acceleration_name, velocity_name as velocity_name
from .key import TIMED as TIMED
from .mapping import substituted as substituted
from .model import Letter as Letter, Parameter as Parameter, Point as Point
from .names import (
    LONGEST as LONGEST,
    RESERVED as RESERVED,
    choice as choice,
    listed as listed,
    nearest as nearest,
    suggestion as suggestion,
)
from .quantity import FormulaError as FormulaError, spell as spell
from .requested_units import (
    ask_for_units as ask_for_units,
    fits as fits,
    question as question,
)
from .signals import LETTERS as LETTERS
from .tolerance import read_tolerance as read_tolerance
from .unit import Unit as Unit, UnitError as UnitError
