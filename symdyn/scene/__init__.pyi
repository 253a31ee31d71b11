"""Names that `symdyn.scene` offers; each is imported when it is first used."""

from .binding import (
    bind as bind,
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
from .declaration.reading import Written as Written, read_bounded as read_bounded
from .examples import Starter as Starter, example as example, examples as examples
from .forces.body_load import load as load
from .forces.contact import knife_edge as knife_edge, rolling as rolling
from .forces.damper import damper as damper
from .forces.spring import spring as spring
from .forces.velocity_row import row as row
from .scene_files import (
    SceneLike as SceneLike,
    format_to_write as format_to_write,
    read as read,
    read_noting as read_noting,
    scene_of as scene_of,
    write_text as write_text,
)
from .schema import schema as schema
from .symbolic import with_force_parameters as with_force_parameters, with_symbols as with_symbols
from .ten_parameters import INERTIAL as INERTIAL, with_symbolic_inertia as with_symbolic_inertia
from .toml import read_text as read_text, tables_of as tables_of
from .units import SceneUnits as SceneUnits
from .values.formula import parse as parse
from .values.model import (
    Scene as Scene,
)
from .values.quantity import Quantity as Quantity
