"""Base parameters as formulas: those of the literature, and a scene that has them alone moves as the declared one."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest
import sympy
from arms import spatial_arm
from mechanisms import COUPLED, TREES

from symdyn.algebra.form import Number
from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.dynamics import Workspace, base_parameters
from symdyn.dynamics.closed_forms.frames_and_parameters import (
    SLIDING,
    TURNING,
    base_parameter_forms,
    with_base_parameters,
)
from symdyn.dynamics.recursive.reduced_tree import reframe
from symdyn.dynamics.recursive.tree_dynamics import rnea
from symdyn.emit.print.equations_text import base_parameters_text
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op, evaluate, reachable, substitute
from symdyn.scene import body as rigid, parse, prismatic, revolute, scene, with_symbolic_inertia
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))

from robots_dh import ROBOTS, robot, robot_scene

SCENES = [*TREES, *COUPLED[:3], spatial_arm()]


def assert_formulas(one, known):
    """Every formula is the known one, as polynomials; no other parameter is left."""
    found = base_parameter_forms(one)
    graph = Graph()
    claims = [
        Claim(name, "ours", "theirs", (form.express(graph),), (parse(known[name]).express(graph),))
        for name, form in found
    ]

    assert [name for name, _ in found] == list(known)
    assert {result.verdict for result in prove(claims)[1]} == {Verdict.PROVED}


def test_the_rx90_has_the_base_parameters_of_khalil_and_dombre_table_9_4():
    below = "(m3 + m4 + m5 + m6)"
    table = {
        "ZZR1": f"Izz1 + Iyy2 + a3**2*{below} + Iyy3",
        "mxR2": f"mx2 + a3*{below}",
        "myR2": "my2",
        "XXR2": f"Ixx2 - Iyy2 - a3**2*{below}",
        "XYR2": "Ixy2",
        "XZR2": "Ixz2 - a3*mz3",
        "YZR2": "Iyz2",
        "ZZR2": f"Izz2 + a3**2*{below}",
        "mxR3": "mx3",
        "myR3": "my3 + mz4 + d4*(m4 + m5 + m6)",
        "XXR3": "Ixx3 - Iyy3 + Iyy4 + 2*mz4*d4 + d4**2*(m4 + m5 + m6)",
        "XYR3": "Ixy3",
        "XZR3": "Ixz3",
        "YZR3": "Iyz3",
        "ZZR3": "Izz3 + Iyy4 + 2*mz4*d4 + d4**2*(m4 + m5 + m6)",
        "mxR4": "mx4",
        "myR4": "my4 - mz5",
        "XXR4": "Ixx4 + Iyy5 - Iyy4",
        "XYR4": "Ixy4",
        "XZR4": "Ixz4",
        "YZR4": "Iyz4",
        "ZZR4": "Izz4 + Iyy5",
        "mxR5": "mx5",
        "myR5": "my5 + mz6",
        "XXR5": "Ixx5 + Iyy6 - Iyy5",
        "XYR5": "Ixy5",
        "XZR5": "Ixz5",
        "YZR5": "Iyz5",
        "ZZR5": "Izz5 + Iyy6",
        "mxR6": "mx6",
        "myR6": "my6",
        "XXR6": "Ixx6 - Iyy6",
        "XYR6": "Ixy6",
        "XZR6": "Ixz6",
        "YZR6": "Iyz6",
        "ZZR6": "Izz6",
    }

    assert_formulas(robot_scene(robot("rx90")), table)


def flat(joints, gravity):
    """Links of full inertia on vertical axes."""
    names = [f"b{k}" for k in range(1, len(joints) + 1)]
    bare = scene(
        "flat",
        parameters=dict.fromkeys(("d2", "d3", "g")),
        gravity=gravity,
        bodies=[rigid(name) for name in names],
        joints=[
            (prismatic if kind == "P" else revolute)(f"j{k}", parent, child, axis=[0, 0, 1], origin=[origin, 0, 0])
            for k, (kind, origin, parent, child) in enumerate(zip(*joints_of(joints, names), strict=True), start=1)
        ],
    )
    return with_symbolic_inertia(bare)


def joints_of(joints, names):
    return [kind for kind, _ in joints], [origin for _, origin in joints], ["ground", *names[:-1]], names


def test_a_planar_two_link_arm_has_five_in_the_vertical_plane():
    arm = flat([("R", 0), ("R", "d2")], ["-g", 0, 0])

    known = {"mxR1": "mx1 + d2*m2", "myR1": "my1", "ZZR1": "Izz1 + d2**2*m2", "mxR2": "mx2", "myR2": "my2"}
    assert_formulas(arm, {**known, "ZZR2": "Izz2"})


def test_a_planar_two_link_arm_has_four_in_the_horizontal_plane():
    arm = flat([("R", 0), ("R", "d2")], [0, 0, "-g"])

    assert_formulas(arm, {"ZZR1": "Izz1 + d2**2*m2", "mxR2": "mx2", "myR2": "my2", "ZZR2": "Izz2"})


SCARAS = {  # the mass that slides stays where it is, its first moments across the stroke go to the arm
    "RRRP": {
        "ZZR1": "Izz1 + d2**2*(m2 + m3)",
        "mxR2": "mx2 + d3*m3",
        "myR2": "my2",
        "ZZR2": "Izz2 + d3**2*m3",
        "mxR3": "mx3 + mx4",
        "myR3": "my3 + my4",
        "ZZR3": "Izz3 + Izz4",
        "MR4": "m4",
    },
    "RRPR": {
        "ZZR1": "Izz1 + d2**2*m2",
        "mxR2": "mx2 + mx3",
        "myR2": "my2 + my3",
        "ZZR2": "Izz2 + Izz3 + 2*d3*mx3",
        "MR3": "m3 + m4",
        "mxR4": "mx4",
        "myR4": "my4",
        "ZZR4": "Izz4",
    },
}


@pytest.mark.parametrize("order", SCARAS)
def test_a_scara_feels_of_its_stroke_the_mass_alone(order):
    assert_formulas(flat(list(zip(order, [0, "d2", "d3", 0], strict=True)), [0, 0, "-g"]), SCARAS[order])


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("one", [*SCENES, *map(robot_scene, ROBOTS)], ids=lambda one: one.name)
def test_a_scene_of_its_base_parameters_alone_moves_as_declared(one):
    w = Workspace(one)
    framed = reframe(w.tree)
    names = [f"{name}R{k}" for k in framed.outward() for name in (SLIDING if framed.slides[k] else TURNING)]
    found = {name: substitute([value], {}, w.graph)[0] for name, value in base_parameters(one)}
    reduced = with_base_parameters(framed, [found.get(name, w.graph.zero) for name in names])
    arguments = (w.state.qd, w.state.qdd)
    claim = Claim("ID", "base", "declared", tuple(rnea(reduced, *arguments)), tuple(rnea(framed, *arguments)))

    assert found
    assert prove([claim])[1][0].verdict in (Verdict.PROVED, Verdict.NUMERICAL)


@pytest.mark.parametrize("one", [spatial_arm(), *map(robot_scene, ROBOTS)], ids=lambda one: one.name)
def test_forms_are_the_values(one):
    graph, values = Graph(), dict(base_parameters(one))
    claims = [
        Claim(name, "form", "value", (form.express(graph),), (values[name],))
        for name, form in base_parameter_forms(one)
    ]

    assert {result.verdict for result in prove(claims)[1]} == {Verdict.PROVED}


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("one", SCENES, ids=lambda one: one.name)
def test_forms_of_odd_angles_have_twelve_digits(one):
    forms, values = dict(base_parameter_forms(one)), dict(base_parameters(one))
    for name, value in values.items():
        exact, form = at(value), at(forms.get(name, Number.ZERO).express(Graph()))

        assert form == pytest.approx(exact, rel=1e-10, abs=1e-10)


def at(node):
    """Return the value of a node, parameters between 1/2 and 3/2 by their names."""
    drawn = {x: random.Random(str(x.value)).uniform(0.5, 1.5) for x in reachable([node]) if x.op is Op.SYMBOL}
    return evaluate([node], Floats(), drawn)[0]


# In print


def test_the_formulas_run_in_sympy():
    one = robot_scene(robot("rx90"))
    names: dict[str, object] = {}
    exec("from sympy import *\n" + base_parameters_text(one, "sympy"), names)

    m, d4 = sympy.symbols("m4:7", positive=True), names["d4"]
    assert sympy.expand(names["myR3"] - sum(m) * d4 - names["my3"] - names["mz4"]) == 0


def test_latex_names_wear_their_joint_as_a_subscript():
    text = base_parameters_text(flat([("R", 0), ("P", "d2")], [0, 0, "-g"]))

    assert r"\mathit{ZZ}_{R1} &= 2 d_2 m_{2,x} + I_{1,zz} + I_{2,zz}" in text
    assert r"M_{R2} &= m_2" in text


def test_an_unknown_format_is_told():
    with pytest.raises(EmitError, match="format 'html' is not known"):
        base_parameters_text(flat([("R", 0)], [0, 0, "-g"]), "html")


def test_the_verb_equations_prints_them(capsys):
    words = ["equations", str(Path(__file__).parent.parent / "examples" / "two_link.toml"), "--as", "base-parameters"]

    assert main([*words, "--format", "text"]) == 0
    assert capsys.readouterr().out.splitlines()[:2] == ["mxR1 = -(m1 + m2)*h1", "ZZR1 = (m1 + m2)*h1**2"]
    assert main([*words, "--document"]) == 1
    assert "leave --document out" in capsys.readouterr().err
