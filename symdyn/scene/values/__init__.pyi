"""Names that `symdyn.scene.values` offers; each is imported when it is first used."""

from .body import OUTLINES as OUTLINES, Body as Body, Pose as Pose
from .dimension import (
    force_unit as force_unit,
)
from .dimensional_analysis import ask_for_units as ask_for_units, fits as fits, question as question
from .entry import Faults as Faults, names_in as names_in, shorten as shorten, show as show
from .folding import substituted as substituted, vanishes as vanishes
from .formula import formula_text as formula_text, split_commas as split_commas
from .grammar import (
    GREEK as GREEK,
    LETTERS as LETTERS,
    LONGEST as LONGEST,
    RESERVED as RESERVED,
    LatexSymbol as LatexSymbol,
)
from .joint import (
    Contact as Contact,
    Element as Element,
    Joint as Joint,
    Load as Load,
    Place as Place,
    Strut as Strut,
    acceleration_name as acceleration_name,
    velocity_name as velocity_name,
)
from .key import TIMED as TIMED
from .letters import (
    Input as Input,
    Letter as Letter,
    Parameter as Parameter,
    StateVariable as StateVariable,
    read_tolerance as read_tolerance,
    resets_of as resets_of,
)
from .model import Point as Point
from .quantity import FormulaError as FormulaError, spell as spell
from .unilateral import (
    DryJoint as DryJoint,
    GapContact as GapContact,
    OneWay as OneWay,
    PlaneContact as PlaneContact,
    Stop as Stop,
    Unilateral as Unilateral,
)
from .unit import Unit as Unit, UnitError as UnitError
