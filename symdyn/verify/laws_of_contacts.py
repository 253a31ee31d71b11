"""Laws of contacts that open and close, as claims about their outputs.

    dg/dt = n u                                   the Jacobian of a gap is its derivative
    d/dt (W u) = W u̇ + γ
    M C = Wᵀ,  W C = D,  W a + γ = b              impact matrices, Delassus' matrix; a without contacts
    M (u⁺ - u⁻) = nᵀ Λn + tᵀ Λt                   the impact of one contact alone
    M u̇ + h = τ + Wᵀ λ                            in every mode, and its rows, c = mask, d = slip, h = c (1 - |d|²):
    c (n u̇ + γ) + (1 - c) λn = 0
    h (t u̇ + γ) + (1 - h) (λt + d μ λn) = 0       of dry friction of a joint its largest force in place of μ λn

The last two hold for any numbers c and d, so that one proof is about all modes. Where motions are prescribed, rows of M
are those of the other velocities.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 and 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import Touch, dot, touching
from symdyn.errors import DerivationError
from symdyn.graph import Expr, substitute, tangents
from symdyn.verify.claims import Law, entries, everywhere, product
from symdyn.verify.equality import Claim

Rows = list[tuple[Expr, ...]]


def _touches(w: Workspace) -> tuple[Touch, ...]:
    return w.once(touching, True)


def _by_name(w: Workspace, output: str, columns: bool = False) -> Rows:
    """Return the rows of an output of every contact, or its columns, those that are rows of W, shape (m, each)."""
    found = Rows()
    for touch in _touches(w):
        flat = tuple(entries(w, f"{output}:{touch.law.name}"))
        size, kept = len(flat) // 3, (*([0] if touch.normal else []), *range(1, 1 + len(touch.tangents)))
        found += [flat[k::3] if columns else flat[k * size : (k + 1) * size] for k in kept]
    return found


def _columns(w: Workspace) -> Rows:
    """Return M⁻¹ Wᵀ by row of W, shape (m, nv)."""
    return _by_name(w, "impact_matrix", columns=True)


def _gaps(w: Workspace) -> Claim | None:
    closing = [touch.law.name for touch in _touches(w) if touch.normal and not touch.law.at_rates]
    gaps = [one for name in closing for one in entries(w, f"gap:{name}")]
    if not gaps:
        return None
    n, u = w.state.n, w.state.qd
    rates = [dot(entries(w, f"gap_jacobian:{name}")[:n], u) for name in closing]
    return Claim("gaps", "dg/dt", "n qd", tuple(tangents(gaps, w.state.velocity)), tuple(rates))


def _rates(w: Workspace) -> Claim:
    rates = [dot(row, w.state.qd) for row in _by_name(w, "gap_jacobian")]
    return Claim("gaps and slips", "d/dt (W qd)", "W qdd + Wdot qd", tuple(tangents(rates, w.state.acceleration)),
                 tuple(_accelerations(w, w.state.qdd)))  # fmt: skip


def _accelerations(w: Workspace, qdd: Sequence[Expr]) -> list[Expr]:
    """Return W u̇ + γ, shape (m,)."""
    rows = zip(_by_name(w, "gap_jacobian"), _by_name(w, "gap_jdot"), strict=True)
    return [dot(row, qdd) + bias for row, (bias,) in rows]


def _free(w: Workspace, by_velocity: Sequence[Expr]) -> list[Expr]:
    """Return entries of velocities that are not prescribed."""
    return [by_velocity[k] for k in w.prescribed.free]


def _columns_of_mass(w: Workspace) -> Claim:
    M = entries(w, "mass_matrix")
    left = [x for column in _columns(w) for x in _free(w, product(w, M, column))]
    right = [x for row in _by_name(w, "gap_jacobian") for x in _free(w, row)]
    return Claim("impact matrices", "M C", "W^T", tuple(left), tuple(right))


def _delassus(w: Workspace) -> Claim:
    columns = _columns(w)
    left = [dot(row, column) for row in _by_name(w, "gap_jacobian") for column in columns]
    return Claim("Delassus' matrix", "W M^-1 W^T", "D", tuple(left), entries(w, "delassus"))


def _bias(w: Workspace) -> Claim:
    left = _accelerations(w, entries(w, "forward_dynamics"))
    return Claim("contacts without forces", "W qdd + Wdot qd", "b", tuple(left), entries(w, "contact_bias"))


def _impact(w: Workspace) -> Claim | None:
    left, right, n = list[Expr](), list[Expr](), w.state.n
    for touch in _touches(w):
        with suppress(DerivationError):  # it is no formula
            *after, normal, tangential = derive_one(w, f"impact:{touch.law.name}").entries
            jumps = [x - u for x, u in zip(after, w.state.qd, strict=True)]
            W = entries(w, f"gap_jacobian:{touch.law.name}")
            left += _free(w, product(w, entries(w, "mass_matrix"), jumps))
            right += _free(w, [W[k] * normal + W[n + k] * tangential for k in range(n)])
    return Claim("impacts", "M (qd_after - qd)", "W^T impulse", tuple(left), tuple(right)) if left else None


def _balance(w: Workspace) -> Claim:
    n, found = w.state.n, entries(w, "contact_dynamics")
    left = substitute(entries(w, "inverse_dynamics"), dict(zip(w.state.qdd, found[:n], strict=True)))
    W, zero = _by_name(w, "gap_jacobian"), w.graph.zero
    pushed = [w.graph.total(row[k] * x for row, x in zip(W, found[n:], strict=True)) for k in range(n)]
    forces = [tau + more for tau, more in zip(w.state.tau, pushed or [zero] * n, strict=True)]
    return Claim("modes of contacts", "M qdd + h", "tau + W^T lambda", tuple(_free(w, left)), tuple(_free(w, forces)))


def _modes(w: Workspace) -> Claim:
    found, n, one = derive_one(w, "contact_dynamics"), w.state.n, w.graph.one
    given = {argument.name: iter(argument.symbols) for argument in found.arguments}
    rates, forces = iter(_accelerations(w, found.entries[:n])), iter(found.entries[n:])
    rows = list[Expr]()
    for touch in _touches(w):
        c = next(given["mask"])
        slip = [next(given["slip"]) for _ in range(max(1, len(touch.tangents)))]
        h = c * (one - w.graph.total(d * d for d in slip))
        pushed = one
        if touch.normal:
            pushed = next(forces)
            rows.append(c * next(rates) + (one - c) * pushed)
        for d in slip[: len(touch.tangents)]:
            rows.append(h * next(rates) + (one - h) * (next(forces) + d * touch.friction * pushed))
    return Claim("rows of modes", "what each mode keeps", "0", tuple(rows), (w.graph.zero,) * len(rows))


LAWS_OF_CONTACTS: tuple[Law, ...] = (
    everywhere(_gaps, "gap:", "gap_jacobian:"),
    everywhere(_rates, "gap_jacobian:", "gap_jdot:"),
    Law(("impact_matrix:", "mass_matrix"), None, _columns_of_mass),
    Law(("delassus",), None, _delassus),
    Law(("contact_bias", "forward_dynamics"), None, _bias),
    Law(("impact:", "mass_matrix"), None, _impact),
    Law(("contact_dynamics", "inverse_dynamics"), None, _balance),
    Law(("contact_dynamics",), None, _modes),
)
