"""The reference against what is known without it: hand-derived motions, and joints told twice that must agree."""

from __future__ import annotations

import numpy as np
import pytest
from engine.balance import balance
from engine.jets import Jet, angle, apply
from engine.joints import MOTIONS, RESIDUALS, WRENCHES
from engine.mechanism import KINDS, Mechanism
from engine.states import residual, rows

from symdyn.scene import read_text
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS

NAN = float("nan")

PENDULUM = """
[bodies.rod]
mass = 2
com = [0, 0, -0.5]
inertia = [0.3, 0.3, 0]
inertia_about = "com"
[joints.pin]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 1, 0]
"""

JOINT = """
[bodies.a]
mass = 1
[bodies.b]
mass = 1
com = [0.1, 0.2, 0.3]
[joints.base]
type = "free"
parent = "ground"
child = "a"
[joints.tree]
type = "{kind}"
parent = "a"
child = "b"
{more}
[[loop]]
type = "{kind}"
parent = "a"
child = "b"
{more}
"""

MORE = {
    "revolute": "axis = [1, 2, 3]", "prismatic": "axis = [1, 2, 3]", "helical": "axis = [1, 2, 3]\npitch = 0.7",
    "cylindrical": "axis = [3, 0, 4]", "universal": "axis = [1, 2, 3]\nsecond_axis = [1, 0, 1]", "spherical": "",
    "planar": "axis = [1, -2, 2]", "point_on_line": "axis = [1, 2, 3]", "point_on_plane": "axis = [1, 2, 3]",
    "rod": "length = 1.3",
}  # fmt: skip

PLACED = 'origin = [["Tx", 0.2], ["Rz", 0.4], ["Ry", 0.3]]\ntip = [["Tz", 0.5], ["Rx", 0.6]]'


def test_a_pendulum_swings_and_pulls_as_newton_says() -> None:
    m, q, u = Mechanism(read_text(PENDULUM)), 0.4, 1.5
    found = balance(m.at([q], [u]), np.array([NAN]), np.array([0.0]))
    turning = -2 * 9.81 * 0.5 * np.sin(q) / (0.3 + 2 * 0.25)
    outwards = np.array([-np.sin(q), 0, -np.cos(q)])  # from the pin to the centre of mass
    around = np.array([-np.cos(q), 0, np.sin(q)])
    pull = 2 * (0.5 * turning * around - 0.5 * u**2 * outwards + [0, 0, 9.81])

    assert found.du == pytest.approx([turning])
    assert found.wrenches[0] == pytest.approx([*pull, 0, 0, 0])


def test_a_dropped_body_falls_and_its_spin_stays() -> None:
    scene = read_text(
        '[bodies.b]\nmass = 3\ninertia = [1, 1, 1]\ninertia_about = "com"\n'
        + ('[joints.j]\ntype = "free"\nparent = "ground"\nchild = "b"')
    )
    m, rng = Mechanism(scene), np.random.default_rng(1)
    e = rng.normal(size=4)
    state = m.at([0, 0, 0, *(e / np.linalg.norm(e))], rng.normal(size=6))
    found = balance(state, np.full(6, NAN), np.zeros(6))
    moved = m.at(state.q, state.u, found.du)

    assert moved.twists()[1] == pytest.approx([0, 0, -9.81, 0, 0, 0])


@pytest.mark.parametrize("kind", MORE)
def test_a_joint_beside_its_twin_is_forbidden_nothing(kind: str) -> None:
    m, rng = Mechanism(read_text(JOINT.format(kind=kind, more=f"{MORE[kind]}\n{PLACED}"))), np.random.default_rng(2)
    q = rng.uniform(-0.8, 0.8, len(m.scene.coordinates))
    q[3:7] /= np.linalg.norm(q[3:7])
    if len(m.scene.joints[1].coordinates) > len(m.scene.joints[1].rates):
        q[-4:] /= np.linalg.norm(q[-4:])
    n = len(m.names)
    state = m.at(q, rng.normal(size=n), rng.normal(size=n))
    (loop,) = state.contacts()

    assert residual(m, q)[0] == pytest.approx(0, abs=1e-14)
    assert rows(state) == pytest.approx(0, abs=1e-14)
    assert state.forbidden([loop])[1] == pytest.approx(0, abs=1e-12)
    assert np.linalg.matrix_rank(loop.acting, 1e-9) == len(loop.wrenches) == 12 - n


def test_every_type_is_told_both_ways() -> None:
    custom = {name for name, kind in JOINTS.items() if kind.forbids is None}
    assert set(MOTIONS) == set(JOINTS), "write its motion in MOTIONS of tests/engine/joints.py"
    closing = set(JOINTS) - custom
    assert set(WRENCHES) == closing, "write what it forbids in WRENCHES of tests/engine/joints.py"
    assert set(RESIDUALS) == closing, "write what vanishes in RESIDUALS of tests/engine/joints.py"
    assert set(MORE) == closing - {"free", "fixed"}, "write its keys in MORE of this file"


def test_every_kind_of_element_is_told() -> None:
    open_ = {name for name, kind in FORCES.items() if kind.section in ("contacts", "joints")} | {
        "slack"
    }  # it closes none
    assert set(FORCES) - open_ == KINDS, "write its law in tests/engine/mechanism.py, its name in KINDS there"


def test_an_element_that_the_reference_does_not_know_is_refused() -> None:
    scene = read_text(PENDULUM + '[springs.coil]\njoint = "pin"\nstiffness = 1')
    (coil,) = scene.elements
    object.__setattr__(coil, "kind", "gas_spring")
    with pytest.raises(LookupError, match="no law for gas_spring; write one"):
        Mechanism(scene)


def test_a_number_that_moves_obeys_the_chain_rule() -> None:
    def at(t: float) -> np.ndarray:
        x = 0.7 + 0.3 * t - 0.2 * t**2
        return np.array([np.sin(x), np.sqrt(x), np.exp(x), np.log(x), np.tanh(x), 1 / x, np.arctan2(x * x, x + 1)])

    x, h = Jet(0.7, 0.3, -0.4), 1e-4
    names = ("SIN", "SQRT", "EXP", "LOG", "TANH", "RECIPROCAL")
    found = [*(apply(name, x) for name in names), angle(x * x, x + 1.0)]

    assert [float(one.x) for one in found] == pytest.approx(list(at(0)))
    assert [float(one.v) for one in found] == pytest.approx(list((at(h) - at(-h)) / (2 * h)), abs=1e-7)
    assert [float(one.a) for one in found] == pytest.approx(list((at(h) - 2 * at(0) + at(-h)) / h**2), abs=1e-6)


CHAIN = """
[bodies.b{k}]
mass = {k}.5
com = [0.1, {k}, 0.2]
inertia = [1, 2, 2]
inertia_about = "com"
[joints.j{k}]
type = "{kind}"
parent = "{parent}"
child = "b{k}"
{more}
"""


def test_drives_work_as_energy_grows() -> None:
    parts = zip(("universal", "helical", "rod"), ("ground", "b0", "b1"), range(3), strict=True)
    text = [CHAIN.format(kind=kind, parent=on, k=k, more=f"{MORE[kind]}\n{PLACED}") for kind, on, k in parts]
    m, rng = Mechanism(read_text("".join(text))), np.random.default_rng(3)
    q, n = rng.uniform(-0.5, 0.5, len(m.scene.coordinates)), len(m.names)
    q[-4:] /= np.linalg.norm(q[-4:])
    u, du = rng.normal(size=(2, n))
    rates = m.at(q, u).rates

    def energy(t: float) -> float:
        at = m.at(q + t * rates, u + t * du)
        lifted = sum(m.inertia[b][0] * at.T[b].x[2, 3] + at.T[b].x[2, :3] @ m.inertia[b][1] for b in m.bodies)
        return float(at.twists()[0] @ at.inertias()[0] @ at.twists()[0]) / 2 + 9.81 * lifted

    power = balance(m.at(q, u), du, np.full(n, NAN)).tau @ u

    assert (energy(1e-5) - energy(-1e-5)) / 2e-5 == pytest.approx(power, rel=1e-6)
