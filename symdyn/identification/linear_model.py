"""What a log is held against: driving forces of a scene as its base regressor times base parameters.

Friction, armatures and offsets that the scene does not declare are parameters of the scene that is held against the
log, with the value zero: so they are told like any other, and can be written back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import BaseColumns, Linear
from symdyn.errors import DerivationError, IdentifyError
from symdyn.graph import evaluate, reachable
from symdyn.identification.unknowns import TEN
from symdyn.runtime import load
from symdyn.scene import Quantity, Scene, bind
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint, Parameter, choice, force_unit, velocity_name


@dataclass(frozen=True)
class LinearModel:
    """Driving forces that are linear in what is not known.

    Attributes:
        scene: with a parameter for each term of friction that it did not have.
        names: of the base parameters, shape (p,).
        prior: what the scene says of them, shape (p,); NaN where it has no number.
        rows: indices of the velocities whose row says something, shape (m,).
        jumps: indices of the velocities at whose standstill a force jumps.
        regressor: (q, qd, qdd) of shapes (N, nq), (N, nv), (N, nv) to Y, shape (N, nv, p).
        ten: the same arguments to the columns of the ten parameters of every body, shape (N, nv, 10 bodies); compiled
            when it is called.
    """

    scene: Scene
    names: tuple[str, ...]
    prior: Array
    rows: tuple[int, ...]
    jumps: tuple[int, ...]
    regressor: Callable[[Array, Array, Array], Array]
    ten: Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class Term:
    """One law of the force of a drive that a scene may lack.

    Attributes:
        letter: of its parameter; the number of the joint follows.
        unit: of the parameter, at a joint that turns, and at one that slides.
        text: for tables.
        lacks: whether a joint has none of its own.
        given: the joint with it, from the joint and a symbol.
    """

    letter: str
    unit: tuple[str, str]
    text: str
    lacks: Callable[[Joint], bool]
    given: Callable[[Joint, Quantity], Joint]


def _rubbed(joint: Joint, coulomb: Quantity) -> Joint:
    return replace(joint, dry=FORCES["friction"].noun(joint.name, coulomb))


def _pushed(joint: Joint, offset: Quantity) -> Joint:
    own = joint.forces or (Quantity.ZERO,)
    return replace(joint, forces=(own[0] + -offset, *own[1:]))


FORCE = (force_unit("rad"), force_unit("m"))
"""Units of a generalized force: of a joint that turns, and of one that slides."""

TERMS: dict[str, Term] = {
    "viscous": Term(
        "fv",
        ("N m s/rad", "N s/m"),
        "viscous friction of {}",
        lambda joint: joint.damping == Quantity.ZERO,
        lambda joint, x: replace(joint, damping=x),
    ),
    "coulomb": Term("fc", FORCE, "dry friction of {}", lambda joint: joint.dry is None, _rubbed),
    "offset": Term("f0", FORCE, "offset of the drive of {}", lambda joint: True, _pushed),
    "armature": Term(
        "Ia",
        ("kg m^2", "kg"),
        "rotor inertia at {}",
        lambda joint: joint.armature == Quantity.ZERO,
        lambda joint, x: replace(joint, armature=x),
    ),
}
"""What `identify` may add to every joint with one drive, by its name in `--friction`."""


def with_terms(scene: Scene, terms: Sequence[str]) -> Scene:
    """Return the scene with a parameter of value zero for every term that a driven joint lacks.

    Raises:
        IdentifyError: there is no such term.
    """
    for name in terms:
        if name not in TERMS:
            raise IdentifyError(f"friction: there is no term {name}; {choice(name, tuple(TERMS))}")
    taken = {parameter.name for parameter in scene.parameters} | scene.moving_names
    joints, added = list[Joint](), list[Parameter]()
    for k, joint in enumerate(scene.joints, start=1):
        one = joint
        if len(joint.drives) == 1 and joint.drives[0] is not None and joint.motion is None:
            slides = JOINTS[joint.type].slides(joint)
            for term in (TERMS[name] for name in terms):
                if term.lacks(joint):
                    name = f"{term.letter}{k}"
                    while name in taken:
                        name += "_b"
                    taken.add(name)
                    text = term.text.format(joint.name)
                    added.append(Parameter(name, Quantity.number(0), unit=term.unit[slides], text=text))
                    one = term.given(one, Quantity.symbol(name))
        joints.append(one)
    return replace(scene, joints=tuple(joints), parameters=(*scene.parameters, *added)) if added else scene


def linear_model(scene: Scene, terms: Sequence[str] = ()) -> LinearModel:
    """Return the base regressor of a scene, compiled, and what its columns stand for.

    Args:
        scene: the mechanism; parameters that only inertias are made of need no values.
        terms: of `TERMS`, those that joints lack are added.

    Raises:
        IdentifyError: a parameter of the geometry has no value, the scene has no drives, inputs over time, or parts of
            its forces that no parameter stands for.
        DerivationError: the scene has no driving forces.
    """
    _check(scene)
    declared = {parameter.name for parameter in scene.parameters}
    augmented = with_terms(scene, terms)
    # what is zero drops out of a derivation: open, it stays
    opened = [p if p.name in declared else replace(p, value=None) for p in augmented.parameters]
    scene = replace(augmented, parameters=tuple(opened))
    told = BaseColumns.of(Workspace(scene)).named()
    if not told:
        raise IdentifyError(f"{scene.name}: its driving forces depend on no parameter")
    w = Workspace(scene)
    try:
        entries = derive_one(w, "base_regressor").entries
        left = Linear.of(w).remainder()
    except DerivationError as error:
        raise IdentifyError(f"{scene.name}: {error}") from None
    if not all(one.is_zero for one in left):
        raise IdentifyError(
            f"{scene.name}: a part of its driving forces depends on no linear parameter, such as a spring whose "
            "stiffness and free length are both parameters; --bind the free length"
        )
    met = {str(node.value) for node in reachable(list(entries))}
    free = {parameter.name for parameter in scene.free_parameters}
    lacking = [p.name for p in scene.parameters if p.name in free & met]
    if lacking:
        told_how = ",".join(f"{name}=1" for name in lacking)
        raise IdentifyError(
            f"{scene.name}: {', '.join(lacking)} {'has' if len(lacking) == 1 else 'have'} no value, and it is geometry "
            f"or gravity, which is not identified; give it, as in --bind {told_how}"
        )
    known = {p.name: float(p.value.at({}) or 0) for p in augmented.parameters if p.value is not None}
    prior = np.array([_number(value, known) for _, value in told])
    bound = bind(scene, dict.fromkeys(free, 1)) if free else scene
    call = load(bound, ["base_regressor"]).base_regressor

    def regressor(q: Array, qd: Array, qdd: Array) -> Array:
        found: Array = np.asarray(call(q, qd, qdd), dtype=np.float64)
        return found

    @cache
    def every() -> Callable[..., Array]:
        found: Callable[..., Array] = load(bound, ["regressor"]).regressor
        return found

    def ten(q: Array, qd: Array, qdd: Array) -> Array:
        found: Array = np.asarray(every()(q, qd, qdd), dtype=np.float64)[:, :, : TEN * len(bound.bodies)]
        return found

    rng = np.random.default_rng(1)
    q, qd, qdd = (rng.uniform(-1, 1, (8, n)) for n in (len(scene.coordinates), *[len(scene.velocities)] * 2))
    said = np.abs(np.nan_to_num(regressor(q, qd, qdd))).max(axis=(0, 2))
    rows = tuple(int(k) for k in np.flatnonzero(said > 0))
    return LinearModel(augmented, tuple(name for name, _ in told), prior, rows, _jumps(scene), regressor, ten)


def _number(value: object, known: dict[str, float]) -> float:
    """Return the value of a formula, NaN where a parameter has none."""
    names = {str(node.value): node for node in reachable([value]) if str(node.value) in known}  # type: ignore[list-item]
    try:
        return float(evaluate([value], Floats(), {node: known[name] for name, node in names.items()})[0])  # type: ignore[list-item]
    except (KeyError, ArithmeticError, ValueError, TypeError):
        return float("nan")


def _jumps(scene: Scene) -> tuple[int, ...]:
    """Return the velocities of joints whose dry friction has an ideal sign, or nearly one."""
    rates = {name: k for k, name in enumerate(scene.velocities)}
    dry = {velocity_name(name) for joint in scene.joints if joint.dry is not None for name in joint.coordinates}
    return tuple(k for name, k in rates.items() if name in dry)


def _check(scene: Scene) -> None:
    if not any(scene.drives):
        raise IdentifyError(
            f'{scene.name}: no joint has a drive, so no force is measured; name one, as in drive = "tau1", or fit '
            "motions alone, by output error: --by output-error, in Python symdyn.identification.output_error"
        )
    if scene.inputs:
        names = ", ".join(one.name for one in scene.inputs)
        raise IdentifyError(f"{scene.name}: {names}: inputs over time are not identified with; bind numbers in place")
