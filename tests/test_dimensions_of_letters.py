"""Letters without a unit take that of where they stand, and it is shown; where two places disagree both are told."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from dimensional import PENDULUM, output, pendulum

import symdyn
from symdyn.scene import read_text
from symdyn.scene.declaration.dimensions import SceneUnits

ROOT = Path(__file__).parent.parent

SILENT = [  # a letter without a unit, where it stands, and what it is then
    ('mass = "m"', 'mass = "m"\nshape = { type = "ball", radius = "p" }', "m"),
    ("-b*phi_dot", "-p", "N m"),
    ("-b*phi_dot", "-p*phi_dot", "N m s"),
    ("-b*phi_dot", "p*u", "N m/V"),
    ("-b*phi_dot", "l**2*p*phi", "N/m"),
    ("phi - w*t", "phi - p*t", "1/s"),
    ('force = "', 'damping = "p"\nforce = "', "N m s/rad"),
    ('force = "', 'start = "-p"\nforce = "', "rad"),
    ('force = "', 'armature = "m*p**2"\nforce = "', "m"),
    ("-b*phi_dot", "-2*p", ""),
    ("-b*phi_dot", "-b*phi_dot", ""),
]


@pytest.mark.parametrize(("old", "new", "unit"), SILENT)
def test_a_letter_without_a_unit_takes_that_of_where_it_stands(old: str, new: str, unit: str) -> None:

    found = pendulum(old, new)

    assert SceneUnits(found).letters["p"] == unit
    assert next(one for one in found.parameters if one.name == "p").unit == ""


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        (
            'damping = "p"',
            'armature = "p"',
            r"p is in N m s by joints.hinge: damping = p|by joints.hinge: armature = p",
        ),
        ('start = "p"', 'damping = "p/m"', "p"),
        ('armature = "p*m"', 'damping = "p*m"', r"is in kg m\^2, and N m s/rad is asked for|N m s"),
    ],
)
def test_where_two_places_disagree_both_are_said(first: str, second: str, words: str) -> None:
    """In SI that is right, and it is told: nothing says that one letter is not two numbers that are equal."""

    found = pendulum('force = "', f'{first}\n{second}\nforce = "')

    assert SceneUnits(found).letters["p"] == ""
    (said,) = SceneUnits(found).doubtful
    assert re.search(words, said)
    assert "p has no unit and is used with two dimensions: joints.hinge" in said


def test_what_no_letter_tells_alone_is_told_by_all_equations_together() -> None:
    """Two letters, two products of them: neither place tells one of them, both together do."""

    text = PENDULUM.replace("p = 7", "p = 7\nr = 2").replace('mass = "m"', 'mass = "p*r"')
    found = read_text(text.replace('com = [0, "-l", 0]', 'com = [0, "p/r", 0]'))
    units = SceneUnits(found).letters

    assert (units["p"], units["r"]) == ("kg^(1/2) m^(1/2)", "kg^(1/2)/m^(1/2)")
    (p, r) = SceneUnits(read_text(text.replace('com = [0, "-l", 0]', 'com = [0, "p*r", 0]'))).doubtful
    assert all("p*r is in kg, and m is asked for" in one for one in (p, r))


@pytest.mark.runs("cc")
def test_units_that_are_told_are_shown_everywhere() -> None:
    """Columns of runs, tables of LaTeX, of lessons, of notebooks and of linear models."""
    from symdyn.notebook.mechanisms import _tables
    from symdyn.teach import walkthrough

    text = PENDULUM.replace('m = { value = 2, unit = "kg" }', "m = 2").replace('"V"', '""').replace("-b*phi_dot", "u")
    one = read_text(text.replace("phi - w*t", "phi") + output("m*l*phi_dot**2"))

    run = symdyn.simulate(one, forces="u=0.1", until=0.1)
    assert {c.name: c.unit for c in run.columns if c.name in ("u", "y")} == {"u": "N m", "y": "N"}
    assert symdyn.linearize(one, start={"phi": 0}, outputs=["y"]).outputs.units == ("N",)
    assert any(row[0] == "m" and row[2] == "kg" for table in (_tables(one),) for row in _cells(str(table)))
    page = symdyn.equations(one).latex(document=True)
    assert r"$m$ & parameter & $\mathrm{kg}$" in page
    assert "kg" in str(walkthrough(one))


@pytest.mark.mends("30.lessons.1.5")
@pytest.mark.runs("cc")
def test_the_multiplier_of_a_row_is_a_power_over_the_rate_that_vanishes() -> None:
    from symdyn.simulation.columns import columns

    text = (ROOT / "examples" / "two_link.toml").read_text(encoding="utf-8") + ROWS_OF_RATES
    found = {one.name: one.unit for one in columns(read_text(text), ["multiplier_geared", "multiplier_slides"])}
    page = symdyn.equations(read_text(text)).latex(document=True)

    assert (found["multiplier_geared"], found["multiplier_slides"]) == ("N m", "N")
    assert "of row geared, N m" in page
    assert "of row slides, N." in page


ROWS_OF_RATES = """
[constraints.geared]
formula = "q1_dot + q2_dot"
[constraints.slides]
formula = "h1*q1_dot"
"""


def _cells(page: str) -> Iterator[list[str]]:
    for row in re.findall(r"<tr>(.*?)</tr>", page, re.S):
        yield re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, re.S)
