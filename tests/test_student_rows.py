"""Answers where a scene's rows have no closed form: written out, in letters, or with what the rows carry eliminated."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from test_student_answers import _benchmark

from symdyn.scene import read, read_text
from symdyn.teach.student.derivation_check import check_derivation

CRANE = """
gravity = [0, 0, "-g"]
parameters = { m = 50, J = 4, r = 0.2, l = 6, g = 9.81 }
bodies.drum = { inertia = ["J", "J", "J"], inertia_about = "com" }
bodies.load.mass = "m"
ropes.rope = { through = [{ body = "drum", radius = "r", axis = [0, 1, 0], turn = "right" }, "load"], length = "l" }

[joints.axle]
type = "revolute"
parent = "ground"
child = "drum"
axis = [0, 1, 0]
coordinate = "phi"
drive = "T"

[joints.place]
type = "custom"
parent = "ground"
child = "load"
steps = [["Tx", "u"], ["Tz", "-w"]]
coordinates = ["u", "w"]
units = ["m", "m"]
drive = false
start = ["-r", "l"]
"""
OF_CRANE = (
    ("phi", "T = J φ'' + r λ1", "right", ""),
    ("w", "m (g - w'') (u² + w²) = λ1 [w √(u² + w² - r²) - r u]", "right", ""),
    ("u", "m r u'' = G_{1,2} (T - J φ'')", "right", ""),  # without λ1, in the letter that is printed
    ("phi", "J φ'' = T + r λ1", "wrong", "termsign"),
    ("u", "m u'' = -λ1 u/√(u² + w²)", "wrong", ""),  # to the axle, not to the rim
    ("w", "w'' = g", "wrong", "untied"),
)
"""What is asked of a crane, an answer, what it is, and the rule that both doors tell."""


@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="the page's program runs in node")
def test_rows_without_a_closed_form_may_be_written_out(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = [
        {"scene": "crane", "asked": {"kind": "equation", "coordinate": q}, "answer": text} for q, text, *_ in OF_CRANE
    ]

    rows = _benchmark(monkeypatch).sealed({"scenes": {"crane": CRANE}, "answers": asked})

    for (_, shell, page, _), (*_, verdict, rule) in zip(rows, OF_CRANE, strict=True):
        assert shell.verdict == page.verdict == verdict
        assert {rule} - {""} <= {*shell.rules} & {*page.rules}


def test_points_are_drawn_where_a_row_has_a_value() -> None:
    cam = read_text(
        """
        parameters = { m = 1, J = 2, r = 0.2, h = 1.5 }
        bodies.disc = { inertia = ["J", "J", "J"], inertia_about = "com" }
        bodies.rod.mass = "m"
        joints.axle = { type = "revolute", parent = "ground", child = "disc", axis = [0, 1, 0], coordinate = "phi" }
        joints.rail = { type = "prismatic", parent = "ground", child = "rod", axis = [1, 0, 0], coordinate = "s" }
        constraints.cam.formula = "s_dot - phi_dot*sqrt(h**2 - r**2*sin(phi)**2)"
        """,
        "cam.toml",
    )

    (right,) = check_derivation("τ1 + τ2 √(h² - r² sin² φ) = J φ'' + m s'' √(h² - r² sin² φ)", cam)
    (wrong,) = check_derivation("τ1 + τ2 √(h² - r² sin² φ) = J φ''", cam)

    assert right.right
    assert not wrong.right


@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="the page's program runs in node")
def test_multipliers_are_along_the_axes_of_the_ground_or_of_the_rows_at_both_doors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The lesson writes the slider-crank's λ along the ground, the equations along the rod: both are right."""
    benchmark, scene = (
        _benchmark(monkeypatch),
        read(Path(__file__).parents[1] / "examples/slider_crank.toml").as_parameters(),
    )
    typed = {
        "m3 x_ddot = -k x_dot + λ1": True,
        "m3 x_ddot = -k x_dot + λ1 cos(phi + psi) - λ2 sin(phi + psi)": True,
        "m3 x_ddot = -k x_dot - λ1": False,
        "m3 x_ddot = -k x_dot + λ2": False,
    }

    shell = [benchmark.sealed_in_shell({"answer": text}, "tau:3", scene).right for text in typed]
    page = [first.right for first, _ in benchmark.sealed_on_page([("tau:3", text) for text in typed], scene)]

    assert shell == page == list(typed.values())


@pytest.mark.runs("node")
@pytest.mark.skipif(shutil.which("node") is None, reason="the page's program runs in node")
def test_a_constant_for_an_energy_has_no_known_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    benchmark, scene = _benchmark(monkeypatch), read(Path(__file__).parents[1] / "examples/pendulum.toml")

    shell = benchmark.sealed_in_shell({"answer": "m g l"}, "P:", scene.as_parameters())
    ((page, _),) = benchmark.sealed_on_page([("P:", "m g l")], scene.as_parameters())

    assert (shell.right, shell.rules) == (page.right, page.rules) == (False, ())
