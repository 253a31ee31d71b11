"""Names that `symdyn.scene` offers; each is imported when it is first used."""

from .build import (
    body as body,
    custom as custom,
    cylindrical as cylindrical,
    dh_table as dh_table,
    fixed as fixed,
    free as free,
    helical as helical,
    input_signal as input_signal,
    joint as joint,
    loop as loop,
    output as output,
    parameter as parameter,
    planar as planar,
    point as point,
    point_on_line as point_on_line,
    point_on_plane as point_on_plane,
    prismatic as prismatic,
    revolute as revolute,
    rod as rod,
    scene as scene,
    signal as signal,
    spherical as spherical,
    state as state,
    table as table,
    universal as universal,
)
from .declaration.coupling import lock as lock
from .declaration.declare import schema as schema
from .declaration.dimensions import SceneUnits as SceneUnits
from .declaration.reading import Written as Written, read_bounded as read_bounded
from .feet import with_contacts as with_contacts
from .forces.applied_forces import damper as damper, load as load, spring as spring
from .forces.constraints import constraint as constraint, knife_edge as knife_edge, rolling as rolling
from .forces.flows import flow as flow
from .forces.ropes import elastic_rope as elastic_rope, rope as rope, rope_damping as rope_damping
from .forces.unilateral import contact as contact, gap_contact as gap_contact
from .joint_limits import limits as limits
from .scene_files import (
    SceneLike as SceneLike,
    Starter as Starter,
    example as example,
    examples as examples,
    format_to_write as format_to_write,
    read as read,
    read_noting as read_noting,
    scene_of as scene_of,
    write_text as write_text,
)
from .symbolic import (
    INERTIAL as INERTIAL,
    bind as bind,
    with_force_parameters as with_force_parameters,
    with_symbolic_inertia as with_symbolic_inertia,
    with_symbols as with_symbols,
    with_values as with_values,
    without_hidden_zeros as without_hidden_zeros,
)
from .toml import read_text as read_text, tables_of as tables_of
from .values.formula import parse as parse
from .values.model import Scene as Scene
from .values.quantity import Quantity as Quantity
