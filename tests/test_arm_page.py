"""Inverse kinematics in print: every choice of signs against the output's branches."""

from __future__ import annotations

from itertools import product
from math import pi

import numpy as np
import pytest
from test_arm_outputs import ARMS, FREE, PUMA, WRIST, by_dh, functions

import symdyn
from symdyn.emit.print import printed_text
from symdyn.emit.print.formulations_page import FormulationPage
from symdyn.errors import DerivationError, EmitError
from symdyn.scene import Scene
from symdyn.teach.derivations.afterwards import inverse_kinematics_steps
from symdyn.teach.document import Formula
from symdyn.teach.languages import languages
from symdyn.teach.lesson import Prose

WHAT = "inverse-kinematics"
FUNCTIONS = {"sin": np.sin, "cos": np.cos, "sqrt": lambda x: x**0.5 if x >= 0 else np.nan, "atan2": np.arctan2}


CROSSING = by_dh("crossing", (0.4, 0, "pi/2"), (0, 0.6, "0"), (0, 0.12, "-pi/2"), *WRIST)


@pytest.mark.runs("cc")
@pytest.mark.parametrize("scene", [PUMA, CROSSING, ARMS["against"], ARMS["ur"]], ids=lambda scene: scene.name)
def test_signs_of_the_page_are_the_branches_of_the_output(scene: Scene) -> None:
    rows = [row for group in FormulationPage(scene, WHAT).groups for row in group.rows]
    code = [(row.name, compile(str(row.form.to_sympy()), row.name, "eval")) for row in rows]
    (solve, pose), told = functions(scene), []
    T = pose(np.array([0.4, -0.9, 1.3, 0.8, -1.1, 2.2]))
    given = {f"R{i + 1}{j + 1}": T[i, j] for i, j in product(range(3), range(3))}
    given |= {f"p{i + 1}": T[i, 3] for i in range(3)}
    for signs in product((1, -1), repeat=3):
        known = {**given, **{f"sigma{k}": sign for k, sign in zip((1, 3, 5), signs, strict=True)}}
        for name, formula in code:
            known[name] = eval(formula, FUNCTIONS, known)
        told.append([known[x] for x in scene.coordinates])
    branches = solve(T)
    real, found = (x[~np.isnan(x).any(axis=1)] for x in (branches, np.array(told)))
    off = np.abs((found[:, None] - real + pi) % (2 * pi) - pi).max(axis=2)

    assert len(real) == len(found) >= 4
    assert max(off.min(axis=0).max(), off.min(axis=1).max()) < 1e-9


def test_the_page_says_what_is_parallel_and_meets_what_signs_choose_and_where_they_choose_nothing() -> None:
    page = printed_text(ARMS["ur"], "text", WHAT)

    assert "the axes of q2, q3, q4 are parallel, those of q5, q6 meet in a point" in page
    assert "makes 8 branches" in page
    assert "sigma3 chooses the elbow up or down; its branches meet where r3 = 0" in page
    assert page.endswith("q4 = -q2 - q3 + phi")
    assert "r1" not in (crossing := printed_text(CROSSING, "text", WHAT))
    assert "any angle will do where the point where the last axes meet is on axis 1" in crossing
    assert r"$\sigma_3$ chooses" in printed_text(PUMA, "latex", WHAT, document=True)


def test_letters_of_the_page_are_none_of_the_scene() -> None:
    page = printed_text(FREE, "text", WHAT)

    assert "d3_ = " in page
    assert "r3 = sigma3*sqrt((a3**2 + d4**2)*a2**2 - d3_**2)" in page


@pytest.mark.parametrize("scene", [PUMA, CROSSING, ARMS["ur"], FREE], ids=lambda scene: scene.name)
def test_a_lesson_has_the_formulas_of_the_page_and_their_geometry_in_every_language(scene: Scene) -> None:
    page, told = [row for group in FormulationPage(scene, WHAT).groups for row in group.rows], set()
    for language in languages():
        lesson = Prose(scene, language)
        first, *angles = steps = list(inverse_kinematics_steps(lesson))
        told.add(str([part for step in steps for part in (step.claim, step.reason)]))
        assert [(x.left, x.form) for step in angles for x in step.blocks if isinstance(x, Formula)] == [
            (row.name, row.form) for row in page
        ]
        assert all(str(one.look).count("'bar'") == key.endswith("_") for key, one in lesson.names.items())
        looks = [str(name.look) for name in lesson.names.values()]
        assert len(looks) == len(set(looks)) > len(angles) == 6 + ("phi" in lesson.names)
        assert first.blocks
    assert len(told) == len(languages())
    assert not list(inverse_kinematics_steps(Prose(symdyn.example("two_link"), "en")))


def test_other_arms_have_no_such_page() -> None:
    with pytest.raises(DerivationError, match="two_link: inverse_kinematics:tool: it is of six joints"):
        printed_text(symdyn.example("two_link"), "text", WHAT)
    with pytest.raises(EmitError, match="the formulation kane is no inverse-kinematics"):
        printed_text(PUMA, "text", WHAT, formulation="kane")
