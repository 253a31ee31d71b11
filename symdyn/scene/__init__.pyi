"""Names that `symdyn.scene` offers; each is imported when it is first used."""

from .binding import (
    bind as bind,
    read_bindings as read_bindings,
    with_values as with_values,
    without_hidden_zeros as without_hidden_zeros,
)
from .build import (
    body as body,
    dh_table as dh_table,
    given as given,
    looked_at as looked_at,
    parameter as parameter,
    point as point,
    scene as scene,
)
from .build_joints import (
    custom as custom,
    cylindrical as cylindrical,
    fixed as fixed,
    free as free,
    helical as helical,
    joint as joint,
    loop as loop,
    planar as planar,
    point_on_line as point_on_line,
    point_on_plane as point_on_plane,
    prismatic as prismatic,
    revolute as revolute,
    rod as rod,
    spherical as spherical,
    universal as universal,
)
from .declaration.locking import lock as lock
from .declaration.reading import ReadOptions as ReadOptions, Written as Written, read_bounded as read_bounded
from .declaration.value_in_unit import (
    as_written as as_written,
    ask_for_units as ask_for_units,
    in_si_here as in_si_here,
    question as question,
)
from .examples import example as example, example_text as example_text, examples as examples
from .forces.body_load import load as load
from .forces.contact import knife_edge as knife_edge, rolling as rolling
from .forces.damper import Damper as Damper, damper as damper
from .forces.force_kind import ForceKind as ForceKind, Pull as Pull
from .forces.force_table import FORCES as FORCES
from .forces.friction import Friction as Friction
from .forces.spring import Spring as Spring, spring as spring
from .forces.velocity_row import Formula as Formula, row as row
from .joints.joint_kind import JointKind as JointKind, JointMotion as JointMotion, Move as Move
from .joints.joint_table import JOINTS as JOINTS
from .joints.start import start_of as start_of
from .scene_files import (
    FileLike as FileLike,
    SceneLike as SceneLike,
    format_to_write as format_to_write,
    read as read,
    read_noting as read_noting,
    scene_of as scene_of,
    write_text as write_text,
)
from .schema import schema as schema
from .starters import STARTERS as STARTERS, starter as starter
from .symbolic import with_force_parameters as with_force_parameters, with_symbols as with_symbols
from .ten_parameters import INERTIAL as INERTIAL, with_symbolic_inertia as with_symbolic_inertia
from .toml import read_text as read_text, tables_of as tables_of
from .units import SceneUnits as SceneUnits
from .values.body import Body as Body, Particle as Particle, Pose as Pose
from .values.element import (
    Contact as Contact,
    Element as Element,
    Load as Load,
    Place as Place,
    Row as Row,
    Strut as Strut,
)
from .values.folding import FormulaError as FormulaError
from .values.formula import parse as parse
from .values.joint import (
    Coupling as Coupling,
    Joint as Joint,
    Limits as Limits,
    acceleration_name as acceleration_name,
    velocity_name as velocity_name,
)
from .values.model import (
    GROUND as GROUND,
    Input as Input,
    Parameter as Parameter,
    Point as Point,
    Scene as Scene,
    Signal as Signal,
)
from .values.outline import OUTLINES as OUTLINES
from .values.quantity import Quantity as Quantity, number as number, symbol as symbol
from .values.spelling import spell as spell
