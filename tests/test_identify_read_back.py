"""What was identified is written, read back and asked for a fresh motion: it predicts as well as the fit says.

Mechanisms are drawn by seed: trees of turning and sliding joints and loops, whose damping, dry friction, armature and
springs are absent, numbers or names, mixed over joints; any of them may be added by `friction`. Some drives show
currents and have a log with a payload. The truth differs from the scene in every value. The forces that the file gives
are compared with the true ones; the table of the fit states how far off they may be.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.dynamics import linear_parameters
from symdyn.graph import evaluate
from symdyn.identification import Payload, identified, identify
from symdyn.identification.linear_model import unknowns
from symdyn.identification.report import written
from symdyn.scene import bind
from symdyn.scene.forces.applied_forces import Friction
from symdyn.scene.values.quantity import Quantity

pytestmark = pytest.mark.runs("cc")

TERMS = ("viscous", "coulomb", "armature", "offset")
"""What `friction` may add."""

NOISE = 1e-3
"""Standard deviation of a measured force, in parts of its root mean square."""

AXES = [[0, 0, 1], [0, 1, 0], [1, 0, 0]]

LOAD = (1.5, (0.2, 0.15, 0.1))
"""Mass, kg, and place on the last body, m, of a payload: on no axis through that frame, so every drive feels it."""

LOST = {"urdf": ("armature", "offset"), "gains": ("offset",), "loop": ("offset",)}
"""Terms that a kind has not: URDF holds none of the two, and an offset shows no current."""


SLIDER = """
name = "s"
gravity = [0, 0, 0]
[parameters]
{letter} = {{ value = 2 }}
[bodies.block]
mass = 3
[joints.rail]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
damping = 0.3
"""
MIXED = {
    "spring": SLIDER.format(letter="k") + 'friction = { coulomb = "k" }\n[springs.a]\njoint = "rail"\nstiffness = 5',
    "letter": SLIDER.format(letter="mR1") + 'friction = { coulomb = "mR1" }',
}
"""A name behind a number, and one that is called as a base parameter."""


@dataclass(frozen=True)
class Drawn:
    """A mechanism as it is declared, and as it is.

    Attributes:
        declared: its file.
        true: the file of the one that is measured.
        terms: for `friction`.
        gains: of drives that show currents, N m/A or N/A, by name; {} where forces are measured.
    """

    declared: str
    true: str
    terms: tuple[str, ...]
    gains: dict[str, float]


LEAN = "atan2(0.3*sqrt(3)/2, sqrt(1 - (0.3*sqrt(3)/2)**2))"
"""Of the rod of a loop against its rail where the crank is at 60 degrees."""


def drawn(seed: int, kind: str = "tree") -> Drawn:
    """Return a mechanism by its seed: a "tree", what "urdf" can hold of one, one with "gains", or a "loop"."""
    draw = np.random.default_rng([seed, len(kind)])
    terms = tuple(one for one in TERMS if draw.random() < 0.4 and one not in LOST.get(kind, ()))
    count = 1 if kind == "loop" else int(draw.integers(1, 4))
    files = []
    held: dict[str, tuple[str, float, float]] = {}  # of each letter or number: how it stands, before, true
    lines: list[str] = []

    def value(what: str, before: float) -> str:
        """Return a value that the scene has, as a number or a name, and keep what it truly is."""
        way = str(draw.choice(("number", "name")))
        held[what] = way, before, before * float(draw.uniform(1.5, 4))
        return f"<{what}>" if way == "number" else f'"{what}"'

    def acts(what: str, share: float = 0.7) -> bool:
        return bool(draw.random() < share)

    at = "ground"
    for k in range(1, count + 1):
        turns = kind == "loop" or bool(draw.random() < 0.6)
        mass, com = draw.uniform(0.5, 3), draw.uniform(-0.3, 0.3, 3).round(2).tolist()
        six = [0.1, 0.12, 0.15]
        lines += [
            f"[bodies.b{k}]", f"mass = <mass{k}>", f"com = {com}", f"inertia = {six}", 'inertia_about = "com"',
            f"[joints.j{k}]", f'type = "{"revolute" if turns else "prismatic"}"', f'parent = "{at}"',
            f'child = "b{k}"', f"axis = {AXES[int(draw.integers(3)) if kind != 'loop' else 0]}",
            f"origin = {draw.uniform(-0.3, 0.3, 3).round(2).tolist() if kind != 'loop' else [0, 0, 0]}",
            f'coordinate = "x{k}"', f'drive = "F{k}"',
        ]  # fmt: skip
        held[f"mass{k}"] = ("number", round(mass, 3), round(mass * 1.4, 3))
        if acts("damping"):
            lines.append(f"damping = {value(f'visc{k}', 0.2)}")
        if acts("dry", 0.6):
            lines.append("friction = { coulomb = " + value(f"dry{k}", 0.3) + " }")
        if kind != "urdf" and acts("armature", 0.5):
            lines.append(f"armature = {value(f'rotor{k}', 0.05)}")
        at = f"b{k}"
    if kind == "loop":  # two more bars close over the drive's one
        lines += [
            "[bodies.rod]", "mass = 0.7", "com = [1, 0, 0]", "inertia = [0, 0.1, 0.1]", 'inertia_about = "com"',
            "[joints.pin]", 'type = "revolute"', 'parent = "b1"', 'child = "rod"', "axis = [0, 0, 1]",
            "origin = [0.6, 0, 0]", 'coordinate = "psi"', "drive = false", f'start = "-pi/3 - {LEAN}"',
            f"damping = {value('pin', 0.1)}",
            "[bodies.piston]", "mass = 1.2",
            "[joints.rail]", 'type = "prismatic"', 'parent = "ground"', 'child = "piston"', "axis = [1, 0, 0]",
            'coordinate = "s"', "drive = false", 'start = "0.3 + 2*sqrt(1 - (0.3*sqrt(3)/2)**2)"',
            f"damping = {value('rail', 0.4)}",
            "[[loop]]", 'name = "close"', 'type = "revolute"', 'parent = "rod"', 'child = "piston"', "axis = [0, 0, 1]",
            "origin = [2, 0, 0]",
        ]  # fmt: skip
        lines = [line.replace('coordinate = "x1"', 'coordinate = "x1"\nstart = "pi/3"') for line in lines]
    if kind != "urdf":
        for k in range(1, count + 1):
            if acts("spring", 0.5):
                lines += [f"[springs.s{k}]", f'joint = "j{k}"', f"stiffness = {value(f'stiff{k}', 4.0)}"]
    letters = [f"{name} = {{ value = <{name}> }}" for name, (way, *_) in held.items() if way == "name"]
    text = "\n".join([f'name = "drawn{seed}"', "gravity = [0, -9.81, 0]", "[parameters]", *letters, *lines])
    for which in (1, 2):
        files.append(re.sub(r"<(\w+)>", lambda m, which=which: repr(round(held[m[1]][which], 4)), text))  # type: ignore[misc]
    gains = {f"F{k}": float(draw.uniform(0.2, 2)) for k in range(1, count + 1)} if kind == "gains" else {}
    return Drawn(files[0], files[1], terms, gains)


def moved(scene, seed, seconds=6.0):
    """Return times, positions, velocities and accelerations of sums of sines, shape (N, n)."""
    draw, n = np.random.default_rng(seed), len(scene.coordinates)
    t = np.arange(0, seconds, 0.01)
    q, qd, qdd = np.zeros((3, len(t), n))
    for k in range(1, 8):
        w, (a, b) = 2 * np.pi * k / seconds, draw.normal(size=(2, n)) / (2 + k)
        s, c = np.sin(w * t)[:, None], np.cos(w * t)[:, None]
        q, qd, qdd = q + a * s + b * c, qd + w * (a * c - b * s), qdd - w * w * (a * s + b * c)
    return t, q, qd, qdd


def closed(scene, seed, seconds=6.0):
    """Return the same of a loop: the first coordinate is led, the others follow from the start."""
    from scipy.integrate import cumulative_trapezoid

    t, q, qd, qdd = moved(scene, seed, seconds)
    led = np.pi / 3 + 0.8 * (q[:, 0] - q[0, 0])
    v, a = 0.8 * qd[:, 0], 0.8 * qdd[:, 0]
    ratio = np.sin(led) * 0.3  # 2 sin(beta) = 0.6 sin(led), beta the rod's angle below the rail
    beta = np.arcsin(ratio)
    beta_v = 0.3 * np.cos(led) * v / np.cos(beta)
    beta_a = (0.3 * (np.cos(led) * a - np.sin(led) * v**2) + np.sin(beta) * beta_v**2) / np.cos(beta)
    s = 0.6 * np.cos(led) + 2 * np.cos(beta)
    s_v = -0.6 * np.sin(led) * v - 2 * np.sin(beta) * beta_v
    s_a = -0.6 * (np.cos(led) * v**2 + np.sin(led) * a) - 2 * (np.cos(beta) * beta_v**2 + np.sin(beta) * beta_a)
    assert np.allclose(cumulative_trapezoid(s_v, t), s[1:] - s[0], atol=1e-2)
    return t, *(np.stack(one, axis=1) for one in ((led, -led - beta, s), (v, -v - beta_v, s_v), (a, -a - beta_a, s_a)))


def forces(scene, q, qd, qdd):
    """Return what the drives do, shape (N, drives); forces that the drives of no row do are left out."""
    tau = np.asarray(symdyn.lambdify(scene, "inverse_dynamics")(q, qd, qdd))
    return tau[:, [k for k, one in enumerate(scene.drives) if one]] if tau.shape[1] == len(scene.drives) else tau


def fitted(case: Drawn, folder: Path, kind: str):
    """Return the fit, the true scene, and motions."""
    motion = closed if kind == "loop" else moved
    for name, text in (("declared", case.declared), ("true", case.true)):
        (folder / f"{name}.toml").write_text(text)
    scene, true = symdyn.read(folder / "declared.toml"), symdyn.read(folder / "true.toml")
    names = [one for one in scene.drives if one]
    draw = np.random.default_rng(5)

    def log(seed: int, loaded: bool) -> dict[str, np.ndarray]:
        t, q, qd, qdd = motion(true, seed)
        tau = forces(true, q, qd, qdd)
        if loaded:
            tau = tau + forces(heavier(true, load), q, qd, qdd) - forces(true, q, qd, qdd)
        tau = tau + NOISE * np.sqrt(np.mean(tau**2, axis=0)) * draw.normal(size=tau.shape)
        shown = {name: tau[:, k] / case.gains.get(name, 1.0) for k, name in enumerate(names)}
        return {"t": t, **{name: q[:, k] for k, name in enumerate(true.coordinates)}, **shown}

    more = {}
    load = Payload(scene.bodies[-1].name, *LOAD, (0, 0, 0), log=1)
    logs = [log(1, False)]
    if case.gains:
        logs.append(log(2, True))
        more = {"units": dict.fromkeys(case.gains, "A"), "payloads": load}
    return identify(scene, logs, friction=case.terms, **more), true, motion


def heavier(scene, load: Payload):
    """Return the scene with a payload on its last body."""
    from symdyn.identification.identified_scene import body_of_ten

    known = unknowns(scene)
    ten = known.ten(known.values)[-1] + load.ten
    return replace(scene, bodies=(*scene.bodies[:-1], body_of_ten(scene.bodies[-1], ten)))


def with_dry(scene, path: Path):
    """Return the scene of a robot file with the friction that this holds and readers leave out."""
    of_one = r'<joint name="(\w+)"(?:(?!</joint>).)*?friction="([^"]+)"'
    found = dict(re.findall(of_one, path.read_text(), re.DOTALL))
    return replace(
        scene,
        joints=tuple(
            replace(
                j, dry=Friction(j.name, symdyn.scene.values.formula.quantity(found[j.name])), friction=Quantity.ZERO
            )
            if j.name in found
            else j
            for j in scene.joints
        ),
    )


def predicts(seed: int, kind: str, folder: Path) -> None:
    """Assert that the file of a drawn mechanism predicts a fresh motion as well as the table says."""
    case = drawn(seed, kind)
    found, true, motion = fitted(case, folder, kind)
    made = identified(found)
    format = "urdf" if kind == "urdf" else "toml"
    path = folder / f"made.{format}"
    path.write_text(written(made, format).text)
    again = symdyn.read(path)
    if format == "urdf":
        again = with_dry(again, path)
    _, q, qd, qdd = motion(true, 77)
    truth = forces(true, q, qd, qdd)
    count = len(found.model.names)
    rows = [k for k, one in enumerate(true.drives) if one]
    Y = found.model.regressor(q, qd, qdd)
    Y = Y[:, rows] if Y.shape[1] == len(true.drives) else Y
    sure = np.sqrt(np.mean(np.einsum("nij,jk,nik->ni", Y, found.covariance[:count, :count], Y), axis=0))
    table = np.sqrt(np.mean((Y @ found.after[:count] - truth) ** 2, axis=0))
    assert [one.name for one in again.joints] == [one.name for one in true.joints]
    back = forces(replace(again, gravity=true.gravity), q, qd, qdd)
    file = np.sqrt(np.mean((back - truth) ** 2, axis=0))
    size = np.sqrt(np.mean(truth**2, axis=0))
    assert (file <= 2 * table + 5 * sure + 1e-6 * size).all(), (
        f"seed {seed}, {kind}, {case.terms}: off by {file} N m or N, the table by {table} ± {sure}, of {size}"
        f"\n{case.declared}"
    )


FEW = [(0, "tree"), (4, "urdf"), (4, "gains"), (2, "loop")]
"""Seeds of the normal run."""


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.mends("30.robots.1")
@pytest.mark.mends("30.class.joined")
@pytest.mark.parametrize(("seed", "kind"), FEW)
def test_what_was_identified_predicts_a_fresh_motion_from_its_file(seed: int, kind: str, tmp_path: Path) -> None:
    predicts(seed, kind, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["tree", "urdf", "gains", "loop"])
@pytest.mark.parametrize("seed", range(5, 35))
def test_every_kind_of_parameter_at_every_joint_predicts_from_its_file(seed: int, kind: str, tmp_path: Path) -> None:
    predicts(seed, kind, tmp_path)


@pytest.mark.wide(3)
@pytest.mark.parametrize(
    "name",
    [
        *(one for one in symdyn.scene.examples() if one != "rocket"),
        *(pytest.param(one, marks=pytest.mark.mends("30.robots.1")) for one in MIXED),
    ],
)
def test_base_parameters_are_the_same_by_both_ways_to_them(name: str, tmp_path: Path) -> None:
    """By formulas of the scene's values, and by the linear map that the identified scene is solved with."""
    (path := tmp_path / "mixed.toml").write_text(MIXED.get(name, ""))
    scene = symdyn.read(path) if name in MIXED else symdyn.example(name)
    scene = bind(scene, {p.name: 0.7 + 0.1 * k for k, p in enumerate(scene.free_parameters)})
    known = unknowns(scene)
    letters = {p.name: float(p.value.at({}) or 0) for p in scene.parameters}
    told = linear_parameters(scene, "base_regressor")

    values = [
        evaluate([value], Floats(), {value.graph.symbol(name): x for name, x in letters.items()})[0]
        for _, value in told
    ]
    both = dict(zip(known.base, known.map @ known.values, strict=True))
    assert len({name for name, _ in told}) == len(told)
    assert both == pytest.approx(dict(zip([name for name, _ in told], values, strict=True)), rel=1e-12, abs=1e-12)
    assert known.base == tuple(name for name, _ in told)
