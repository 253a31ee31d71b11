"""What the interactive page computes: the scene's own functions, and where everything is that it draws, as one program.

All parameters are arguments here, those with values too, so that each of them can be moved by hand. The textbook's
equation (5.40), row i, with what else acts on the joint:

    tau_i = Σ k_z,ij q̈_j + Σ k_C,i,jk q̇_j q̇_k + Σ k_D,ij q̇_j² + k_G,i + k_E,i - Q_i

Of a closed mechanism the rows are those of its independent velocities, and all coefficients are reduced to them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from symdyn.draw import Sheet
from symdyn.dynamics import OUTPUTS, Equations, Function, LoopChoices, Workspace, coefficients
from symdyn.errors import DerivationError, TeachError
from symdyn.graph import Expr, substitute
from symdyn.program import Program, choose, lower
from symdyn.scene import Scene
from symdyn.teach.interactive.reduced import ACTING, STATE, Held, function, held, reduced_functions
from symdyn.teach.interactive.vectors import Vectors, vectors
from symdyn.teach.languages import language_of
from symdyn.teach.shown_state import shown_state
from symdyn.verdict import Verdict
from symdyn.verify import Claim, prove

MOST = 8
"""Velocities of the largest mechanism that is shown."""


@dataclass(frozen=True)
class Term:
    """One term of row i.

    Attributes:
        function: a coefficient, "applied_forces" or, of a closed mechanism, "acting".
        entry: of its result, row by row.
        row: i, from 0.
        indices: those of the coefficient's name after its letter, from 0.
        rates: velocities, from 0, that it is multiplied by: ("qdd", k), or ("qd", k) once or twice.
        sign: -1 for what acts beside the drives.
    """

    function: str
    entry: int
    row: int
    indices: tuple[int, ...]
    rates: tuple[tuple[str, int], ...]
    sign: int = 1

    @property
    def of(self) -> str:
        """What it multiplies, as of a printed coefficient."""
        return self.rates[0][0] if self.rates else ""


@dataclass(frozen=True)
class Live:
    """The functions of the page and what they are for.

    Attributes:
        program: coefficients of the rows; "inverse_dynamics", "forward_dynamics" and, where something acts beside
            drives, "applied_forces", shape (nv,); the energies; "drawn_points", shape (K, 3); with quaternions
            "coordinate_rates"; with loops or rows what `reduced_functions` says.
        sheet: what is drawn, and the rows of `drawn_points` that it uses.
        rows: velocities that the rows are about.
        terms: those that do not vanish.
        held: how loops and rows tie the state together; None for a tree.
        led: (coordinate, velocity) of each prescribed motion, in the order of "led_positions", "led_velocities" and
            "led_accelerations", functions of parameters and time.
        arrows: whose the rows of "mass_motions", "actions" and "carried_forces" are.
        stuck: why the motion cannot be computed; "" where it can.
    """

    program: Program
    sheet: Sheet
    rows: tuple[int, ...]
    terms: tuple[Term, ...]
    held: Held | None
    led: tuple[tuple[int, int], ...]
    arrows: Vectors
    stuck: str


def live(
    scene: Scene,
    parameters: Mapping[str, float] | None = None,
    named: Sequence[Expr] = (),
    outlined: Collection[str] = (),
) -> Live:
    """Return what the page of a scene computes, one with loops or rows without prescribed motions, see `by_hand`.

    Loops are assembled at values of parameters, those that lessons show where none are given. `named` are values of
    the state and the parameters on any graph, which the page computes too: "named_values". `outlined` names bodies that
    are drawn as what they look like at these values.

    Raises:
        TeachError: a scene that sliders cannot move.
        DerivationError: no equation of motion exists.
    """
    why = unmovable(scene)
    if why:
        raise TeachError(f"{scene.name}: there is no interactive page, {language_of('en').page[why].format(most=MOST)}")
    values = shown_state(scene).parameters if parameters is None else parameters
    free = replace(scene, parameters=tuple(replace(parameter, value=None) for parameter in scene.parameters))
    workspace = Workspace(free, LoopChoices(parameters=tuple(values.items())))
    functions, tied = _rows(workspace)
    stuck = ""
    try:
        functions += choose(workspace, ("forward_dynamics",), "lagrange" if tied else None)  # with no partition
    except DerivationError as fault:
        stuck = str(fault)
    functions += choose(workspace, ("kinetic_energy", "potential_energy"))
    if len(scene.coordinates) != len(scene.velocities):
        functions += choose(workspace, ("coordinate_rates",))
    if any(not force.is_zero for force in workspace.Q):
        text = "generalized forces Q of loads, dampers, friction and declared forces"
        functions.append(function(workspace, "applied_forces", text, workspace.Q, ("q", "qd")))
    sheet = Sheet(free, workspace.graph, values, outlined)
    text = "points and directions that are drawn, ground frame"
    entries = [x for row in sheet.rows for x in row]
    functions.append(function(workspace, "drawn_points", text, entries, ("q", "qd"), (len(sheet.rows), 3)))
    led, motions = _led(scene), workspace.prescribed
    parts = {"positions": motions.position, "velocities": motions.velocity, "accelerations": motions.acceleration}
    for name, part in parts.items() if led else ():
        functions.append(function(workspace, f"led_{name}", f"{name} that are prescribed", part, ()))
    if named:
        values_shown = substitute(list(named), {}, workspace.graph)
        functions.append(function(workspace, "named_values", "numbers under terms", values_shown, STATE))
    arrows = vectors(workspace, sheet.found)
    equations = Equations(free, workspace.graph, (*functions, *arrows.functions))
    rows = tied.velocities if tied else tuple(range(workspace.state.n))
    terms = _lasting(equations, _terms(equations, rows))
    return Live(lower(equations), sheet, rows, terms, tied, led, arrows, stuck)


def by_hand(scene: Scene) -> Scene:
    """Return the scene that a page moves: a closed one without its prescribed motions, which sliders take over."""
    if not scene.is_closed:
        return scene
    return replace(scene, joints=tuple(replace(joint, motion=None) for joint in scene.joints))


def _led(scene: Scene) -> tuple[tuple[int, int], ...]:
    """Return coordinate and velocity of each prescribed motion, by velocity as `prescribed` has them."""
    pairs = [
        (scene.coordinates.index(joint.coordinates[0]), scene.velocities.index(joint.rates[0]))
        for joint in scene.joints
        if joint.motion is not None
    ]
    return tuple(sorted(pairs, key=lambda pair: pair[1]))


def absence(scene: Scene, language: str) -> str:
    """Return why a page has no sliders, in words; "" where it has."""
    words = language_of(language).page
    return f"{words['absent']} {words[why].format(most=MOST)}" if (why := unmovable(scene)) else ""


def unmovable(scene: Scene) -> str:
    """Return the key in the words of a page of why sliders cannot move a scene; "" where they can."""
    if not scene.coordinates:
        return "still"
    return "many" if len(scene.velocities) > MOST else ""


def _rows(workspace: Workspace) -> tuple[list[Function], Held | None]:
    """Return the functions that rows are made of, and how loops and rows of the scene tie its state together."""
    if workspace.scene.is_closed:
        tied = held(workspace)
        if not tied.velocities:
            raise TeachError(f"{workspace.scene.name}: there is no interactive page, {language_of('en').page['still']}")
        return reduced_functions(workspace, tied), tied
    terms = [name for name in coefficients(workspace.state.n) if OUTPUTS[name].exists_in(workspace.scene)]
    return list(choose(workspace, (*terms, "inverse_dynamics"))), None


def _terms(equations: Equations, rows: Sequence[int]) -> list[Term]:
    """Return all terms of all rows, in the order of (5.40)."""
    names = [function.name for function in equations.functions]
    n = len(rows)
    acting = ACTING if equations.scene.is_closed else "applied_forces"
    present = {name: columns for name, columns in coefficients(n).items() if name in names}
    terms = []
    for i in range(n):
        for name, columns in present.items():
            for place, rates in enumerate(columns, i * len(columns)):
                indices = (i, *dict.fromkeys(j for _, j in rates))
                terms.append(Term(name, place, i, indices, tuple((rate, rows[j]) for rate, j in rates)))
        terms += [Term(name, i, i, (i,), (), -1) for name in names if name == acting]
    return terms


def _lasting(equations: Equations, terms: Sequence[Term]) -> tuple[Term, ...]:
    """Return the terms whose coefficients do not vanish; sums that cancel are found by proof, not by their looks."""
    entries = [equations[term.function].entries[term.entry] for term in terms]
    claims = [Claim(str(k), "coefficient", "zero", (x,), (x.graph.zero,)) for k, x in enumerate(entries)]
    _, findings = prove(claims)
    return tuple(term for term, finding in zip(terms, findings, strict=True) if finding.verdict not in Verdict.HOLD)
