"""Laws of functions that other formulations are written by, and of what linearises a scene by feedback.

Functions of momenta p = M u, and that of Gibbs and Appell:

    H(q, M u) = K + P
    rates(q, M u, τ) = u, d/dt (M u)     along forward dynamics
    dH/dt = u·(τ + Q + Ṁ u)              along the rates, but for ∂H/∂t; Ṁ of states that masses are made of
    ∂R/∂u = p, ∂R/∂p = -u                Routh's function: of velocities that are left, of cyclic momenta
    ṗ = 0                                of cyclic coordinates, which is {p, H}
    ∂S/∂u̇ = M u̇ + c

Feedback linearisation, y an output of the scene:

    FD(q, u, τ(q, u, u̇)) = u̇             of what is led by the forces τ
    FD(q, u, τ) = zero dynamics          of the others, where what is led is held
    y' = ∂y/∂x ẋ, y^(r) = a + B τ        along forward dynamics, r the relative degree
    V' = ∂V/∂u·M⁻¹ Q                     under forces that shape V, zero where nothing is lost
    V' = V'(τ = 0) - |τ|²                under forces τ that damp V

Inverse kinematics, a branch Q_k at a pose, away from where two meet:

    T(Q_k(T(q))) = T(q), x² + y² = l²    l of lengths that are known by another formula
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.mechanism import solve
from symdyn.dynamics.outputs import BRANCHES, arm_angles, away_from_guards
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
from symdyn.verify.claims import Law, driving, entries, everywhere, of_driving, product
from symdyn.verify.equality import Claim


def _at_momenta(w: Workspace, output: str) -> tuple[Expr, ...]:
    """Return an output of momenta at p = M u."""
    found, p = derive_one(w, output), entries(w, "momentum")
    given = {x: y for one in found.arguments if one.name == "p" for x, y in zip(one.symbols, p, strict=True)}
    return tuple(substitute(found.entries, given))


def _total_energy(w: Workspace) -> Claim:
    K, P = entries(w, "kinetic_energy") + entries(w, "potential_energy")
    return Claim("Hamiltonian", "H at p = M qd", "K + P", _at_momenta(w, "hamiltonian"), (K + P,))


def _canonical(w: Workspace) -> Claim:
    moved = w.state.velocity | dict(zip(w.state.qd, entries(w, "forward_dynamics"), strict=True))
    moved |= zip(w.states, w.state_rates, strict=True)
    motion = (*w.state.qd, *tangents(entries(w, "momentum"), moved))
    return Claim("canonical rates", "at p = M qd", "qd, d/dt (M qd)", _at_momenta(w, "canonical_rates"), motion)


def _canonical_power(w: Workspace) -> Claim | None:
    """Return dH/dt = u·(τ + Q + Ṁ u), as port-Hamiltonian equations have it; a motion that is led has more."""
    if w.prescribed.place:
        return None
    n, found = w.state.n, derive_one(w, "canonical_rates")
    symbols = next(one.symbols for one in found.arguments if one.name == "p")
    (H,), u, rates = entries(w, "hamiltonian"), found.entries[:n], found.entries[n:]
    known = dict(zip(w.state.qd, u, strict=True))
    moved = (*substitute(w.state.rates, known), *rates)
    change = tangents([H], dict(zip((*w.state.q, *symbols), moved, strict=True)))
    acting = zip(w.state.qd, w.state.tau, w.Q, w.by_states(w.energy.momenta()), strict=True)
    power = w.graph.total(x * (tau + Q + lost) for x, tau, Q, lost in acting)
    return Claim("canonical power", "dH/dt", "qd.(tau + Q)", tuple(change), tuple(substitute([power], known)))


def _slopes_of_routhian(w: Workspace) -> Claim:
    """Return ∂R/∂u = p of velocities that are left, ∂R/∂p = -u of cyclic ones, at p = M u."""
    (R,), u, p = entries(w, "routhian"), w.state.qd, entries(w, "momentum")
    symbols = next(one.symbols for one in derive_one(w, "routhian").arguments if one.name == "p")
    by = [symbols[k] if k in w.cyclic else u[k] for k in range(w.state.n)]
    slopes = substitute(gradient(R, by), dict(zip(symbols, p, strict=True)))
    right = tuple(-u[k] if k in w.cyclic else p[k] for k in range(w.state.n))
    return Claim("Routh's function", "dR/dqd, dR/dp at p = M qd", "p, -qd", tuple(slopes), right)


def _conserved(w: Workspace) -> Claim | None:
    """Return {p_c, H} = 0 of cyclic coordinates, as rates of momenta without drives."""
    held = dict.fromkeys(w.state.tau, w.graph.zero)
    rates = [substitute(entries(w, "canonical_rates"), held)[w.state.n + k] for k in w.cyclic]
    return Claim("conserved momenta", "{p, H} of cyclic", "0", tuple(rates), (w.graph.zero,) * len(rates))


def _appell(w: Workspace) -> Claim:
    (S,) = entries(w, "gibbs_function")
    slopes = gradient(S, w.state.qdd)
    rest = zip(driving(w), w.Q, entries(w, "gravity_forces"), w.elastic.forces, strict=True)
    right = tuple(tau + Q - g - pull for tau, Q, g, pull in rest)
    return Claim("Appell's equations", "dS/dqdd", "tau + Q - g", tuple(slopes), right)


LAWS_OF_CANONICAL: tuple[Law, ...] = (
    everywhere(_total_energy, "hamiltonian", "momentum", "kinetic_energy", "potential_energy"),
    everywhere(_canonical, "canonical_rates", "momentum", "forward_dynamics"),
    Law(("canonical_rates", "hamiltonian"), None, _canonical_power),
    Law(("routhian", "momentum"), None, _slopes_of_routhian),
    Law(("routhian", "canonical_rates"), None, _conserved),
    of_driving(_appell, "gibbs_function", "gravity_forces"),
)


def _led(at: str, w: Workspace) -> Claim:
    """Return that forces lead what they should, and that the others move by zero dynamics where that is held."""
    names, zero = w.scene.velocities, derive_one(w, f"zero_dynamics{at}")
    forces = dict(zip(w.state.tau, entries(w, f"linearizing_forces{at}"), strict=True))
    motion = substitute(entries(w, "forward_dynamics"), forces)
    others = [names.index(name) for name in zero.labels[0]]
    led = [k for k in range(w.state.n) if k not in (*others, *w.prescribed.place)]
    still = {x[k]: w.graph.zero for k in led for x in (w.state.qd, w.state.qdd)}
    left = (*(motion[k] for k in led), *substitute([motion[k] for k in others], still))
    right = (*(w.state.qdd[k] for k in led), *zero.entries)
    title = f"forces that lead what is {at[1:] or 'driven'}"
    return Claim(title, "FD(q, qd, tau(q, qd, qdd))", "qdd, zero dynamics", left, right)


def _moved(w: Workspace, functions: Sequence[Expr]) -> list[Expr]:
    """Return rates along forward dynamics, by gradients."""
    seeds = w.state.velocity | dict(zip(w.state.qd, entries(w, "forward_dynamics"), strict=True))
    seeds |= {w.graph.symbol("t"): w.graph.one, **dict(zip(w.states, w.state_rates, strict=True))}
    slopes = (gradient(one, list(seeds)) for one in functions)
    return [w.graph.dot(row, seeds.values()) for row in slopes]


def _rates(w: Workspace) -> Claim:
    """Return y' along forward dynamics."""
    right = tuple(_moved(w, entries(w, "outputs")))
    return Claim("rates of outputs", "dy/dt", "slopes times rates of the state", entries(w, "output_rates"), right)


def _decoupled(w: Workspace) -> Claim:
    """Return y^(r) = a + B τ, B for drives."""
    first, found = entries(w, "output_rates"), derive_one(w, "decoupling_matrix")
    rows, columns = found.labels
    later = [row.startswith("second") for row in rows]
    second = iter(_moved(w, [y for y, twice in zip(first, later, strict=True) if twice]))
    rates = [next(second) if twice else y for y, twice in zip(first, later, strict=True)]
    names = (drive or f"force on {u}" for drive, u in zip(w.scene.drives, w.scene.velocities, strict=True))
    forces = dict(zip(names, w.state.tau, strict=True))
    inputs = (w.graph.one, *(forces[name] for name in columns[1:]))
    undriven = {tau: w.graph.zero for tau in w.state.tau if tau not in inputs}
    sums = tuple(product(w, found.entries, inputs))
    return Claim("relative degree", "y' or y''", "a + B tau", tuple(substitute(rates, undriven)), sums)


def _under(kind: str, w: Workspace) -> dict[str, tuple[tuple[Expr, ...], Expr]]:
    """Return such forces of every output that has them, and its rate under them."""
    found = {}
    for name in (one.name for one in w.scene.outputs):
        try:
            forces, (rate,) = entries(w, f"{kind}:{name}"), entries(w, f"output_rate:{name}")
        except DerivationError:  # it is none of that kind
            continue
        found[name] = forces, substitute([rate], dict(zip(w.state.tau, forces, strict=True)))[0]
    return found


def _shaped(w: Workspace) -> Claim:
    """Return that shaped energies change by losses alone."""
    found = _under("shaping_forces", w)
    lost = solve(range(-1, w.state.n), w.lagrange_mass, w.Q)
    slopes = [gradient(V, w.state.qd) for name in found for V in entries(w, f"output:{name}")]
    right = tuple(product(w, [x for row in slopes for x in row], tuple(lost)))
    return Claim("shaped energies", "dV/dt", "what is lost", tuple(rate for _, rate in found.values()), right)


def _damped(w: Workspace) -> Claim:
    """Return that damping takes its own square from the rate."""
    found, still = _under("damping_forces", w), dict.fromkeys(w.state.tau, w.graph.zero)
    rates = (substitute(entries(w, f"output_rate:{name}"), still)[0] for name in found)
    squares = (w.graph.total(x * x for x in forces) for forces, _ in found.values())
    right = tuple(rate - square for rate, square in zip(rates, squares, strict=True))
    return Claim(
        "damped functions", "dV/dt", "dV/dt without drives - tau^2", tuple(rate for _, rate in found.values()), right
    )


def _posed(k: int, w: Workspace) -> Claim:
    """Return that a branch at the pose of any q has that pose; of all frames that were asked for."""
    left, right = list[Expr](), list[Expr]()
    for request, _ in tuple(w.derived):
        of, _, place = request.partition(":")
        if of != "inverse_kinematics":
            continue
        pose, arm = entries(w, f"pose:{place}"), w.once(arm_angles, place)
        asked = dict(zip(derive_one(w, request).arguments[0].symbols, pose, strict=True))
        row = entries(w, request)[len(w.state.q) * k : len(w.state.q) * (k + 1)]
        lengths = {root: arm.lengths[root] for root in reachable(row) if root in arm.lengths}
        roots, squares = [root.args[0] for root in lengths], [one * one for one in lengths.values()]
        found = substitute(away_from_guards([*row, *roots, *squares], arm.lengths), asked)
        left += substitute(pose, dict(zip(w.state.q, found[: len(row)], strict=True)))
        right += pose
        left += found[len(row) : len(row) + len(roots)]
        right += found[len(row) + len(roots) :]
    return Claim(f"inverse kinematics, branch {k + 1}", "T(Q(T(q)))", "T(q)", tuple(left), tuple(right))


LAWS_OF_ARMS = tuple(Law(("inverse_kinematics:",), None, partial(_posed, k)) for k in range(BRANCHES))

LAWS_OF_LINEARIZING: tuple[Law, ...] = (
    Law(("shaping_forces:", "output_rate:"), None, _shaped),
    everywhere(_damped, "damping_forces:", "output_rate:"),
    Law(("linearizing_forces", "zero_dynamics", "forward_dynamics"), None, partial(_led, "")),
    Law(("linearizing_forces:passive", "zero_dynamics:passive", "forward_dynamics"), None, partial(_led, ":passive")),
    everywhere(_rates, "output_rates", "outputs", "forward_dynamics"),
    everywhere(_decoupled, "decoupling_matrix", "output_rates", "forward_dynamics"),
)
