"""Lessons of rotations by quaternions: each formula where the quaternion is one, and Euler's equations by hand."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from lessons import keys_of, lesson_of

from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.dynamics import Workspace, derive_one
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.scene import read
from symdyn.table import Table
from symdyn.teach import Document, walkthrough
from symdyn.teach.document import Braced, Formula, Matrix

EXAMPLES = Path(__file__).parent.parent / "examples"
NAMES = ["free_body", "heavy_top", "rolling_disc"]
UNIT = {"e0": 0.7, "e1": 0.1, "e2": 0.5, "e3": 0.5}


@cache
def lesson(name: str, language: str = "en") -> Document:
    return lesson_of(read(EXAMPLES / f"{name}.toml"), language, formulation="quaternions")


def value_of_symbol(name: str) -> float:
    if name.startswith("euler:"):
        return euler()[name]
    return UNIT.get(name, 0.3 + sum(ord(letter) * (k + 3) for k, letter in enumerate(name)) % 89 / 60)


def worth(node: Expr | None) -> float:
    assert node is not None
    values = {x: value_of_symbol(str(x.value)) for x in reachable([node]) if x.op is Op.SYMBOL}
    return float(evaluate([node], Floats(), values)[0])


@pytest.mark.wide(3)
@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) for name in NAMES])
@pytest.mark.parametrize("language", ["en", "sk"])
def test_every_formula_is_worth_its_name(name: str, language: str) -> None:
    document = lesson(name, language)
    count = 0
    for step, block in document.blocks():
        if isinstance(block, (Formula, Braced)):
            key, form = (block.left, block.form) if isinstance(block, Formula) else (block.value, block.form)
            if not key and block.right is not None:  # an equation in its parts, which on the left has drive and forces
                if not step.key.startswith("equation:"):
                    continue  # what Euler's angles are, and what holds in steady motions alone
                key, form = f"tau:{step.key.partition(':')[2]}", block.right
            truth = document.names[key].node
            assert worth(document.value(form)) == pytest.approx(worth(truth), rel=1e-9, abs=1e-9), step.key
            count += 1
        if isinstance(block, Matrix):
            for form, key in zip(block.entries, block.names, strict=True):
                truth = document.names[key].node
                assert worth(document.value(form)) == pytest.approx(worth(truth), rel=1e-9, abs=1e-9), step.key
    assert count > 20


def rotation(e: list[float]) -> np.ndarray:
    """Return the rotation by Rodrigues' formula, which knows no quaternion."""
    half = np.array(e[1:])
    length = float(np.linalg.norm(half))
    angle, (x, y, z) = 2 * np.arctan2(length, e[0]), half / length
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


@cache
def euler() -> dict[str, float]:
    """Return ψ, θ, φ from the vertical z to the axis y of the heavy top, where the quaternion is `UNIT`, and rates."""
    R = rotation(list(UNIT.values()))
    psi, theta, phi = np.arctan2(R[0, 1], -R[1, 1]), np.arccos(R[2, 1]), np.arctan2(R[2, 2], R[2, 0])
    x, y, z = (value_of_symbol(f"point_w{axis}") for axis in "xyz")
    turns = (z * np.sin(phi) + x * np.cos(phi)) / np.sin(theta)
    values = psi, theta, phi, turns, z * np.cos(phi) - x * np.sin(phi), y - turns * np.cos(theta)
    names = [f"euler:{one}{rate}" for rate in ("", "_dot") for one in ("psi", "theta", "phi")]
    return dict(zip(names, map(float, values), strict=True))


def test_the_matrix_is_that_of_rodrigues() -> None:
    document = lesson("free_body")
    (matrix,) = (block for _, block in document.blocks() if isinstance(block, Matrix))
    shown = [worth(document.value(form)) for form in matrix.entries]
    assert shown == pytest.approx(rotation(list(UNIT.values())).ravel().tolist())


@pytest.mark.long(0)
def test_the_equations_of_the_heavy_top_are_eulers_about_its_point() -> None:
    """I_O ω̇ + ω × I_O ω = h × Rᵀ g, typed in SymPy, with the letters that the lesson gives to numbers."""
    document = lesson("heavy_top")
    e0, e1, e2, e3, a, b, c = sp.symbols("e0 e1 e2 e3 a b c")
    inertia = sp.diag(*(value_of_symbol(f"I{axis}{axis}1") for axis in "xyx"))  # the top is round: I_zz = I_xx
    first, w = sp.Matrix([0, value_of_symbol("my1"), 0]), sp.Matrix([a, b, c])
    up = sp.Matrix([2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), 1 - 2 * (e1**2 + e2**2)])
    rest = w.cross(inertia * w) + first.cross(value_of_symbol("g") * up)
    names = [f"point_w{axis}" for axis in "xyz"]
    at = {sp.Symbol(name): value for name, value in UNIT.items()}
    at |= {x: value_of_symbol(name) for x, name in zip((a, b, c), names, strict=True)}
    for i, name in enumerate(names):
        by_hand = inertia[i, i] * value_of_symbol(f"{name}_dot") + float(rest[i].subs(at))
        assert worth(document.names[f"tau:{i + 1}"].node) == pytest.approx(by_hand)


@pytest.mark.long(0)
def test_what_rolling_says_is_that_the_lowest_point_stands_still() -> None:
    document = lesson("rolling_disc")
    names = [f"flight_{one}" for one in ("vx", "vy", "vz", "wx", "wy", "wz")]
    u, r = np.array([value_of_symbol(name) for name in names]), value_of_symbol("r")
    R = rotation(list(UNIT.values()))
    axis, up = R[:, 1], np.array([0.0, 0.0, 1.0])
    lean = float(np.linalg.norm(np.cross(axis, up)))
    lowest = -r / lean * (up - axis[2] * axis)
    slip = R @ u[:3] + np.cross(R @ u[3:], lowest)
    along = np.cross(axis, up) / lean
    shown = [worth(document.names[key].node) for key in ("s:1", "s:2", "df:3")]
    assert shown == pytest.approx([slip @ along, slip @ np.cross(up, along), slip[2]])
    assert worth(document.names["f:3"].node) == pytest.approx(value_of_symbol("z") - r * lean)


def table(document: Document, key: str) -> dict[str, float]:
    (values,) = (block for step, block in document.blocks() if step.key == key and isinstance(block, Table))
    texts = {row[0].parts[0].name: str(row[1].parts[0]) for row in values.rows}
    return {name: float(text.strip("≈ ").replace("−", "-").replace(" · 10^", "e")) for name, text in texts.items()}


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_the_shown_accelerations_are_those_of_the_generated_equations(name: str) -> None:
    scene, state = read(EXAMPLES / f"{name}.toml"), table(lesson(name), "state")
    w = Workspace(scene)
    values = {w.graph.symbol(key): value for key, value in state.items()} | dict.fromkeys(w.state.tau, 0.0)
    values |= {w.graph.symbol(p.name): float(p.value.value) for p in scene.parameters}
    found = evaluate(derive_one(w, "forward_dynamics").entries, Floats(), values)
    shown = [state[f"{u}_dot"] for u in scene.velocities]
    assert found == pytest.approx(shown, rel=5e-3, abs=2e-2)
    quaternions = [state[key] for key in UNIT]
    assert sum(x * x for x in quaternions) == pytest.approx(1, abs=1e-3)
    assert min(map(abs, quaternions)) > 0.01


@pytest.mark.long(0)
def test_the_angular_momentum_stays_where_no_moment_acts_and_only_there() -> None:
    assert "conserved:flight" in keys_of(lesson("free_body"))
    assert not {
        key for key in keys_of(lesson("heavy_top")) | keys_of(lesson("rolling_disc")) if key.startswith("conserved")
    }


def test_other_scenes_are_told_their_formulation() -> None:
    with pytest.raises(DerivationError, match='formulation="lagrange"'):
        walkthrough(read(EXAMPLES / "two_link.toml"), formulation="quaternions")
    with pytest.raises(DerivationError, match='formulation="multipliers"'):
        walkthrough(read(EXAMPLES / "four_bar.toml"), formulation="quaternions")
    with pytest.raises(DerivationError, match='18 velocities, and 9 is the limit; format="sliders"'):
        walkthrough(read(EXAMPLES / "quadruped.toml"), formulation="quaternions")


@pytest.mark.heavy("md", "html")
@pytest.mark.wide("heavy_top")
@pytest.mark.long(0)
@pytest.mark.parametrize("format", ["md", "html", "notebook", "latex"])
@pytest.mark.parametrize("name", ["heavy_top", "rolling_disc"])
def test_every_format_takes_it(format: str, name: str, tmp_path: Path) -> None:
    arguments = ["--formulation", "quaternions", "--language", "sk", "--format", format, "-o", str(tmp_path)]
    assert main(["walkthrough", str(EXAMPLES / f"{name}.toml"), *arguments]) == 0
