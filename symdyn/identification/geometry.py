"""Where a point of a scene is, over what its geometry is made of: the model of `calibrate`, and poses as measured.

    pose of the point = origin_1 · D_1 · motion(q_1) · tip_1 · origin_2 · D_2 · ... · at · D
    D = Tx Ty Tz Rx Ry Rz       small corrections of the frame before a joint, and of the point, zero in the scene

A correction along the axis of a joint is the zero of its coordinate, `q2_offset`: the joint moves as if its coordinate
were q2 + q2_offset. Corrections are parameters of the scene like its own, so that they can be written back as its
placements. Derivatives are those of the graph, at any values: no angle is taken as small.

Reference: Hollerbach, Khalil and Gautier, Model Identification, Springer Handbook of Robotics (2016), 6.2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from symdyn.algebra import Array, Batches
from symdyn.dynamics.mechanism import body_placements
from symdyn.errors import IdentifyError, SimulateError, choice, listed, nearest
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, evaluate, gradient, reachable
from symdyn.identification.identified_scene import DIGITS, with_parameters
from symdyn.identification.log import in_si
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import Faults, Joint, Point, Pose
from symdyn.simulation import opened
from symdyn.simulation.prescribed import Columns, read_entries

AXES = ("x", "y", "z")

ELEMENTARY = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")
"""Steps of a placement that a correction may be."""

OFFSETS = {"revolute": "R", "prismatic": "T"}
"""Types of joints whose coordinate has a zero along one axis, and the step that it is."""

ORIENTATIONS: Mapping[tuple[str, ...], Callable[[Any, Array], Any]] = {
    ("qx", "qy", "qz", "qw"): lambda Rotation, x: Rotation.from_quat(x),
    ("roll", "pitch", "yaw"): lambda Rotation, x: Rotation.from_euler("xyz", x),  # about fixed x, y, z
    ("rx", "ry", "rz"): lambda Rotation, x: Rotation.from_rotvec(x),
}
"""Columns of an orientation in the ground frame, and how SciPy takes them."""


class Correction(NamedTuple):
    """A step that ends the placement of a joint, or of the point (""); its rank is 1 or 2, of zeros of coordinates 0.

    Of parameters that cannot be told apart those of higher rank keep the scene's values.
    """

    owner: str
    kind: str
    sign: int
    rank: int


def corrections(scene: Scene, point: Point) -> dict[str, Correction]:
    """Return the corrections of the joints between the ground and a point, and of the point, by name."""
    carrier, body, way = {joint.child: joint for joint in scene.joints}, point.body, list[Joint]()
    while body != Scene.GROUND:
        way.insert(0, carrier[body])
        body = carrier[body].parent
    found, own = dict[str, Correction](), {one.name for one in scene.parameters}
    for joint in (one for one in way if one.moves):
        along, sign = _along(joint)
        for kind in ELEMENTARY:
            if kind != along:
                found[f"{joint.name}.{_short(kind)}"] = Correction(joint.name, kind, 1, 1)
            elif (name := f"{joint.coordinates[0]}_offset") not in own:  # else the scene has it already
                found[name] = Correction(joint.name, kind, sign, 0)
    said = f"point {point.name}" if any(one.name == point.name for one in scene.joints) else point.name
    return found | {f"{said}.{_short(kind)}": Correction("", kind, 1, 2) for kind in ELEMENTARY}


def _short(kind: str) -> str:
    return kind[1] if kind[0] == "T" else f"r{kind[1]}"


def _along(joint: Joint) -> tuple[str, int]:
    """Return the step along the axis of a joint, and its sign; "" where it has no such axis."""
    if joint.type not in OFFSETS or not joint.coordinates:
        return "", 1
    numbers = [one.at({}) for one in joint.axis]
    along = [(axis, one) for axis, one in zip(AXES, numbers, strict=True) if one != 0]
    if len(along) != 1 or along[0][1] is None:
        return "", 1
    return OFFSETS[joint.type] + along[0][0], 1 if along[0][1] > 0 else -1


def corrected(scene: Scene, point: Point, steps: Mapping[Correction, Quantity]) -> tuple[Scene, Point]:
    """Return the scene and the point with steps added to placements; of a body that is measured, to its frame."""

    def more(pose: Pose, owner: str) -> Pose:
        return Pose((*pose.steps, *((c.kind, x if c.sign > 0 else -x) for c, x in steps.items() if c.owner == owner)))

    bare = point not in scene.points
    joints = tuple(
        replace(j, origin=more(j.origin, j.name), tip=more(j.tip, "") if bare and j.child == point.body else j.tip)
        for j in scene.joints
    )
    moved = point if bare else replace(point, at=more(point.at, ""))
    return replace(scene, joints=joints, points=tuple(moved if p == point else p for p in scene.points)), moved


@dataclass(frozen=True, eq=False)
class GeometricModel:
    """The pose of a point over coordinates and parameters.

    Attributes:
        scene, point: as declared.
        corrections: by name.
        names: of all parameters that move the point, the scene's own first, shape (p,).
        units: rad, m, or what the scene says, shape (p,).
        values: where they stand in the scene, shape (p,).
        coordinates: those that move the point.
        symbols: of the parameters.
        entries, order: the pose, p and R, and its derivatives by them, and all nodes of these.
        rest: values of other parameters.
    """

    scene: Scene
    point: Point
    corrections: Mapping[str, Correction]
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    coordinates: tuple[str, ...]
    symbols: tuple[Expr, ...]
    entries: tuple[Expr, ...]
    order: Sequence[Expr]
    rest: Mapping[Expr, float]

    @classmethod
    def of(cls, scene: Scene, name: str | None) -> GeometricModel:
        """Return the model of a point or of the frame of a body; None for the only point.

        Raises:
            IdentifyError: there is no such point, it does not move, or moves with what is given over time.
            SimulateError: parameters without a value.
        """
        points = {one.name: Point(one.name, one.name) for one in scene.bodies} | {one.name: one for one in scene.points}
        if name is None and len(scene.points) == 1:
            name = scene.points[0].name
        if name not in points:
            asked = "say which point was measured" if name is None else f"there is no point or body {name}"
            raise IdentifyError(f"{scene.name}: {asked}; {choice(name, points)}")
        point, free, graph = points[name], opened(scene), Graph()
        steps = corrections(scene, point)
        moved, there = corrected(free.scene, point, {one: Quantity.symbol(said) for said, one in steps.items()})
        T = body_placements(moved, graph)[there.body] @ there.at.transform(graph)
        pose = (*T.p, *(entry for row in T.R for entry in row))
        met = {str(node.value) for node in reachable(pose) if node.op is Op.SYMBOL}
        coordinates = tuple(one for one in scene.coordinates if one in met)
        if not coordinates:
            raise IdentifyError(f"{scene.name}: {name} does not move: no joint with a coordinate carries it")
        own = tuple(one.name for one in free.scene.parameters if one.name in met)
        names, known = (*own, *steps), SceneUnits(scene).inferred
        if given := sorted(met - {*names, *scene.coordinates, *free.values}):
            raise IdentifyError(f"{scene.name}: {name} moves with {listed(given)}, too, which a pose does not have")
        symbols = tuple(map(graph.symbol, names))
        units = (*(known.get(one) or "" for one in own), *("rad" if c.kind[0] == "R" else "m" for c in steps.values()))
        values = np.array([free.values.get(one, 0.0) for one in own] + [0.0] * len(steps))
        entries = (*pose, *(slope for entry in pose for slope in gradient(entry, symbols)))
        rest = {graph.symbol(one): value for one, value in free.values.items() if one not in names}
        return cls(scene, point, steps, names, units, values, coordinates, symbols, entries, reachable(entries), rest)

    def at(self, values: Array, q: Array) -> tuple[Array, Array, Array]:
        """Return where the point is, and how that changes with parameters.

        Args:
            values: of the parameters, shape (p,).
            q: of `coordinates`, shape (N, n); rad or m.

        Returns:
            Positions, shape (N, 3), m, and orientations, shape (N, 3, 3), of the point in the ground frame; and their
            derivatives, shape (N, 6, p): of the position, and of small turns about the axes of the ground, rad.
        """
        graph, count = self.symbols[0].graph, len(self.names)
        state = {graph.symbol(name): q[:, k] for k, name in enumerate(self.coordinates)}
        known = {**self.rest, **dict(zip(self.symbols, map(float, values), strict=True)), **state}
        found = evaluate(self.entries, Batches(), known, order=self.order)
        every = np.stack([np.broadcast_to(np.asarray(one, dtype=np.float64), len(q)) for one in found], axis=-1)
        R, slopes = every[:, 3:12].reshape(-1, 3, 3), every[:, 12:].reshape(len(q), 12, count)
        turn = np.einsum("nijp,nkj->nikp", slopes[:, 3:].reshape(-1, 3, 3, count), R)
        w = [turn[:, i, j][:, None] for i, j in ((2, 1), (0, 2), (1, 0))]
        return every[:, :3], R, np.concatenate([slopes[:, :3], *w], axis=1)

    def written(self, values: Mapping[str, float]) -> Scene:
        """Return the scene with other values of its parameters, and with corrections as steps of its placements."""
        own = {name: value for name, value in values.items() if name not in self.corrections}
        steps = {  # in the order of the model
            one: Quantity.number(Fraction(f"{values[name]:.{DIGITS}g}"))
            for name, one in self.corrections.items()
            if values.get(name)
        }
        return corrected(with_parameters(self.scene, own) if own else self.scene, self.point, steps)[0]


def read_poses(model: GeometricModel, data: Any, units: Mapping[str, str]) -> tuple[Array, Array, Array | None]:
    """Return poses of a CSV file, of a data frame or of arrays by name; a column t is not needed.

    Returns:
        Coordinates, shape (N, n), positions, shape (N, 3), m, NaN along axes that were not measured, and orientations,
        shape (N, 3, 3), or None.

    Raises:
        IdentifyError: with every fault, one line each.
    """
    from scipy.spatial.transform import Rotation

    scene, point, faults = model.scene, model.point.name, Faults("")
    every = (*AXES, *(name for names in ORIENTATIONS for name in names))
    plain = {f"{point}.{name}": name for name in every}
    plain |= {name: name for name in every if name not in scene.coordinates}
    try:
        if isinstance(data, (str, Path)):
            table = Columns.read(Path(data), (*model.coordinates, *plain), timed=False)
        elif hasattr(data, "keys"):
            arrays = {name: data[name] for name in data.keys() if name in (*model.coordinates, *plain)}  # noqa: SIM118
            times = np.arange(len(next(iter(arrays.values()), ())))
            found = read_entries({"t": times, **arrays}, "data", faults).tables
            faults.close(IdentifyError)
            table = found[0] if found else Columns("data", times.astype(np.float64), {})
        else:
            raise IdentifyError(f"data: {type(data).__name__} holds no poses; give a CSV file or arrays by name")
    except SimulateError as error:
        raise IdentifyError(error.faults) from None
    kinds = {said: "m" if name in AXES else "1" if name[0] == "q" else "rad" for said, name in plain.items()}
    kinds |= dict(zip(scene.coordinates, SceneUnits(scene).coordinates, strict=True))
    table = in_si(table, units, (), kinds, faults)
    missing = [name for name in model.coordinates if name not in table.values]
    meant = [f"{name} (did you mean {near}?)" if (near := nearest(name, table.values)) else name for name in missing]
    if missing:
        faults.add(table.source, f"has no column {', '.join(meant)}; {point} moves with {listed(model.coordinates)}")
    there = {plain[name]: column for name, column in table.values.items() if name in plain}
    p, R = np.stack([there.get(name, np.full(len(table.t), np.nan)) for name in AXES], axis=-1), None
    for names, turned in ORIENTATIONS.items():
        columns = [there[name] for name in names if name in there]
        if columns and len(columns) < len(names):
            faults.add(table.source, f"has some columns of an orientation, which takes all of {', '.join(names)}")
        elif len(names) == 4 and columns and np.abs(np.linalg.norm(columns, axis=0) - 1).max() > 1e-2:
            faults.add(table.source, f"{', '.join(names)} is no unit quaternion in every row")
        elif columns:
            R = turned(Rotation, np.stack(columns, axis=-1)).as_matrix()
    if not there and not faults.lines:
        ways = " or ".join(", ".join(names) for names in ORIENTATIONS)
        faults.add(table.source, f"has no pose of {point}; name columns x, y, z or {point}.x, ..., and turns {ways}")
    faults.close(IdentifyError)
    return np.stack([table.values[name] for name in model.coordinates], axis=-1), p, R
