"""Operations of what symdyn derives beside published counts and those of other generators; writes a table.

    python benchmarks/operation_counts.py        writes docs/operation-counts.md

Published figures are those of benchmarks/data/op_counts.json with where they were read; figures of other generators
were measured on the code that they emit for the same tables.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from cases import chain
from robots_dh import ROBOTS, robot_scene

from symdyn.dynamics import Equations, Workspace, derive_one
from symdyn.dynamics.outputs import Counts
from symdyn.program import formulate, lower, prepare
from symdyn.scene import Scene, read, with_symbols
from symdyn.table import Table

ROOT = Path(__file__).parent.parent
sys.path.append(str(ROOT / "tests"))

from counts_of_literature import state_dependent_counts  # noqa: E402

PAGE = ROOT / "docs" / "operation-counts.md"
DATA = ROOT / "benchmarks" / "data" / "op_counts.json"

OUTPUTS: tuple[tuple[str, str | None], ...] = (
    ("inverse_dynamics", None),
    ("mass_matrix", None),
    ("forward_dynamics", "crba"),
)
"""What is counted, and the formulation where another one is longer."""

DERIVATIVES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("inverse_dynamics_derivatives", ("recursive", "reverse")),
    ("forward_dynamics_derivatives", ("recursive",)),
    ("coriolis_matrix", ("derivatives", "crba")),
)
"""What is counted by the formulation that costs least, and the formulations that may."""

PEERS = (
    ("OpenSYMORO", "inverse dynamics", "panda", "414/354"),
    ("OpenSYMORO", "inverse dynamics", "iiwa", "397/337"),
    ("OpenSYMORO", "inverse dynamics", "puma560", "363/313"),
    ("OpenSYMORO", "inverse dynamics", "stanford", "324/279"),
    ("OpenSYMORO", "mass matrix", "iiwa", "280/202"),
    ("OpenSYMORO", "mass matrix", "puma560", "309/211"),
    ("CasADi over Pinocchio", "forward dynamics", "puma560", "924/758"),
)
"""Measured elsewhere on the code that these generators emit, multiplications/additions."""

BARS = (
    ("panda", "inverse dynamics", (275, 262)),
    ("puma560", "inverse dynamics", (232, 218)),
    ("general_6r", "inverse dynamics", (370, 305)),
    ("puma560", "mass matrix", (115, 113)),
    ("puma560", "forward dynamics", (400, 380)),
    ("puma560_diagonal", "inverse dynamics", (195, 160)),
)
"""What was set out to be reached, multiplications and additions of what is emitted."""

NAMES = ("inverse dynamics", "mass matrix", "forward dynamics")
"""Of `OUTPUTS`."""

STRUCTURES = {
    "general 6R": "full",
    "general 6R inertia matrix": "full",
    "general 6R forward dynamics": "full",
    "PUMA (as quoted)": "diagonal",
    "RX-90/TX-90": "simplified, many parameters zero",
    "PUMA 560": "not stated where it was read",
    "Stanford arm": "simplified",
}
"""The inertia structure that a published line assumes."""

HEAD = """# Operation counts

Made by `python benchmarks/operation_counts.py`; `tests/test_operation_counts.py` holds the numbers.

Multiplications/additions of the part that depends on the state; what depends on parameters alone, such as regrouped
inertias, is worked out once. Subtractions are additions, and so is twice a number. Sines and cosines are listed as
pairs, at most one a joint; the first joint needs none, since gravity lies along its axis. Counted are the derived
equations, before any pass over the program.

Robots are given by modified Denavit-Hartenberg tables with free lengths (`benchmarks/robots_dh.py`). *Full*: all ten
inertial parameters of each link are free about its frame. *Diagonal*: no products of inertia about the link frames.
*Zero pattern of Corke*: `examples/puma560.toml` with a free parameter for each of its numbers that is not zero.
"""

PREPARED = """
## Work on parameters alone

All operations of one call of the finished program, passes applied, without and with `--prepare`, which leaves work on
parameters alone to one call of `prepare`. Here twice a number is a multiplication.
"""

EMITTED = """
## What is emitted

The same for generated programs: the formulations that are preferred, after all passes, which trade operations
by their cost.
"""

WANTED = """
What was set out to be reached. Most was, by special cases that made no code faster and are gone; which, and what
they saved, stands in [decisions.md](decisions.md).
"""

PUBLISHED = """
## Published

A figure was read in its source, or is unverified. A line for another
inertia structure than ours is no comparison.
"""

DERIVED = """
## Derivatives

By the formulation of fewest operations, before any pass: ∂τ/∂q, ∂τ/∂q̇ and M together; ∂q̈/∂q, ∂q̈/∂q̇ and M⁻¹
together, q̈ worked out on the way; C(q, q̇) of Christoffel's symbols. *Sweeps* is reverse differentiation of inverse
dynamics on the graph, row by row.
"""

MEANS = """
## What does it

- Frames along the joints' axes, `Rx Tx Rz Tz`, whatever the file says: a standard table counts as a modified one does.
- Inertias regrouped to base parameters, by second moments J = Σ m r rᵀ: what lies on a revolute axis (m, h_z, J_zz)
  goes to the parent, as does all of a prismatic joint's J. In a chain of revolute joints no body keeps a mass.
- Force `U h` and moment `U J - J Uᵀ` from one matrix U = [ω̇]× + [ω]×[ω]×: 13 multiplications for the moment of a body.
- Where the next axis is an axis of the frame, U z is a turned column of the parent's U; it gives ωy² and two entries of
  ω̇ without a multiplication.
- The last body of a branch stays in axes that do not turn with its joint: h and J turn for 12 multiplications in place
  of ω, U z, acceleration and wrench for 20, and half of the products of ω are the parent's. M has the same turned J.
- A symmetric matrix turns about an axis for 8 multiplications, `w = c (a - b) - 2 s d`.
- In M(q) a momentum from outside passes parallel axes in one turn by the sum of their angles. From parallel axes on a
  joint of the ground, of which that feels one component, J leaves by the sum of angles as well, without shifts.
- Derivatives: velocities of bodies count from the origin at hand, so that the origin's own takes no part; twice of
  them is carried, so that no result is doubled; a joint is seen from the inner end of its joint offset.
- Derivatives of forward dynamics: LᵀDL once, one reciprocal a pivot, M⁻¹ symmetric from L⁻¹.
- Between parallel axes a shift along them stays at the outer joint, so that forces further in need not be known.
"""


def zero_pattern() -> Scene:
    """Return the PUMA 560 of Corke and Armstrong-Helouvry with a free parameter for every number but zero."""
    named = with_symbols(read(ROOT / "examples" / "puma560.toml"), "all")
    return replace(named, parameters=tuple(replace(p, value=None) for p in named.parameters))


def cases() -> list[tuple[str, str, str, Scene]]:
    """Return name, text, inertia structure and scene of everything that is counted."""
    full = [(one.name, one.text, "full", robot_scene(one)) for one in ROBOTS]
    puma = next(one for one in ROBOTS if one.name == "puma560")
    return [
        *full,
        ("puma560_diagonal", puma.text, "diagonal", robot_scene(puma, diagonal=True)),
        ("puma560_zeros", puma.text, "zero pattern of Corke", zero_pattern()),
    ]


def measured(scene: Scene) -> list[Counts]:
    """Return the counts of `OUTPUTS`."""
    workspace = Workspace(scene)
    return [state_dependent_counts(derive_one(workspace, name, formulation)) for name, formulation in OUTPUTS]


def emitted(scene: Scene) -> list[Counts]:
    """Return the counts of `OUTPUTS` in generated programs: the preferred formulations, after all passes."""
    program = lower(formulate(scene, [name for name, _ in OUTPUTS]))
    return [state_dependent_counts(routine.function) for routine in program.routines]


def prepared(scene: Scene) -> tuple[list[tuple[Counts, Counts]], Counts, int]:
    """Return what one call of each of `OUTPUTS` costs without and with `prepare`, what that costs, and its values."""
    workspace = Workspace(scene)
    functions = tuple(derive_one(workspace, name, formulation) for name, formulation in OUTPUTS)
    program = lower(Equations(scene, workspace.graph, functions))
    first, *rest = prepare(program).routines
    pairs = [(before.counts, after.counts) for before, after in zip(program.routines, rest, strict=True)]
    return pairs, first.counts, len(first.function.entries)


def derived(scene: Scene) -> list[Counts]:
    """Return the counts of `DERIVATIVES`, and of the first by reverse sweeps."""
    workspace = Workspace(scene)
    counted = {
        name: {
            formulation: state_dependent_counts(derive_one(workspace, name, formulation))
            for formulation in formulations
        }
        for name, formulations in DERIVATIVES
    }
    cheapest = [min(by_formulation.values(), key=lambda counts: counts.cost) for by_formulation in counted.values()]
    return [*cheapest, counted[DERIVATIVES[0][0]]["reverse"]]


def chains() -> list[tuple[str, str, Scene]]:
    """Return text, inertia structure and scene of chains of revolute joints."""
    return [(f"chain of {n}", "numbers", chain(n)) for n in (4, 8, 16)]


def page() -> str:
    """Return the page in Markdown."""
    about = {name: (text, structure) for name, text, structure, _ in cases()}
    ours = {name: measured(scene) for name, _, _, scene in cases()}
    after = {name: emitted(scene) for name, _, _, scene in cases()}
    heads = ("robot", "inertia", "inverse dynamics", "M(q)", "forward dynamics")
    derivatives = ("robot", "inertia", "inverse dynamics", "sweeps", "forward dynamics", "C(q, q̇)")
    before = [(*about[name], *_shown(*found), found[0].sincos) for name, found in ours.items()]
    parts = [
        f"{HEAD}\n## symdyn\n",
        Table((*heads, "sin/cos"), before, range(2, 6)).markdown(str),
        EMITTED,
        Table(heads, [(*about[name], *_shown(*found)) for name, found in after.items()], range(2, 5)).markdown(str),
        WANTED,
        _reached(about, after).markdown(str),
        PREPARED,
        Table((*heads, "prepare, once", "values"), list(_prepared()), range(2, 7)).markdown(str),
        DERIVED,
        Table(derivatives, list(_derived()), range(2, 6)).markdown(str),
        "\n## Other generators, full inertias\n",
        _peers(ours).markdown(str),
        PUBLISHED,
        _published().markdown(str),
    ]
    return "\n".join(parts) + "\n" + MEANS


def _reached(about: dict[str, tuple[str, str]], after: dict[str, list[Counts]]) -> Table[str]:
    """Return what was set out to be reached."""
    rows = []
    for name, output, (multiplications, additions) in BARS:
        found = after[name][NAMES.index(output)]
        reached = found.multiplications <= multiplications and found.additions <= additions
        verdict = "reached" if reached else "**missed**"
        rows.append((*about[name], output, f"{multiplications}/{additions}", _pair(found), verdict))
    return Table(("robot", "inertia", "output", "wanted", "emitted", ""), rows, (3, 4))


def _prepared() -> Iterator[tuple[str | int, ...]]:
    for _, text, structure, scene in cases():
        pairs, once, values = prepared(scene)
        yield text, structure, *(f"{_pair(old)} → {_pair(new)}" for old, new in pairs), _pair(once), values


def _derived() -> Iterator[tuple[str, ...]]:
    for text, structure, scene in [*((text, structure, scene) for _, text, structure, scene in cases()), *chains()]:
        inverse, forward, coriolis, sweeps = derived(scene)
        yield text, structure, *_shown(inverse, sweeps, forward), _pair(coriolis)


def _peers(ours: dict[str, list[Counts]]) -> Table[str]:
    """Return what other generators need."""
    text = {one.name: one.text for one in ROBOTS}
    rows = [
        (text[name], output, peer, figure, _pair(ours[name][NAMES.index(output)]))
        for peer, output, name, figure in PEERS
    ]
    return Table(("robot", "output", "generator", "theirs", "symdyn"), rows, (3, 4))


def _published() -> Table[str]:
    """Return the figures of others."""
    rows = []
    for row in json.loads(DATA.read_text(encoding="utf-8"))["rows"]:
        trust = "read" if row["confidence"] == "A" else "unverified"
        figure = f"{row['mults']}/{row['adds']}" if row["mults"] else ""
        structure = STRUCTURES.get(row["robot"], "")
        rows.append((row["method"], row["robot"], structure, figure, row["formula"], row["source"], trust))
    return Table(("method", "robot", "inertia", "mult./add.", "formula", "source", ""), rows, (3,))


def _shown(inverse: Counts, other: Counts, forward: Counts) -> tuple[str, str, str]:
    """Return the counts of three outputs, of forward dynamics divisions too."""
    return _pair(inverse), _pair(other), f"{_pair(forward)}, {forward.divisions} div"


def _pair(counts: Counts) -> str:
    return f"{counts.multiplications}/{counts.additions}"


def main() -> int:
    """Write the page."""
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
