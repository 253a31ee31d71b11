"""Inverse dynamics as a loop over the rows of a table: nothing is left out, zeros are multiplied by.

The text of C that `emit/targets/c/loops` writes says the same, term by term and under the same names; so what is
proved of these expressions is proved of that loop.

    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of frame i, in frame i
    U           [ω̇]× + [ω]× [ω]×: a + U r is the acceleration of a point r of the body
    f, n        force on body i by its parent and moment about the origin of frame i, in frame i
    F           f and n, those of the bodies beyond added on the way in

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 5.3; see `rnea` for U and the moments.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.recursive.joint_table import JointTable
from symdyn.graph import Expr
from symdyn.spatial import Vec


def rnea_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q), shape (n,), N m or N, by the loop; positive accelerates."""
    graph = q[0].graph
    zero = graph.zero
    motion = [((zero,) * 3, (zero,) * 3, table.ground, (zero,) * 9)]
    turn, F = [], [[zero] * 6]
    for row, p, v, dv in zip(table.rows, q, qd, qdd, strict=True):  # outward: motion, and what it takes
        angle = zero if row.slides else p
        c, s = graph.cos(angle), graph.sin(angle)
        c, s = c * row.zero[0] - s * row.zero[1], s * row.zero[0] + c * row.zero[1]
        turn.append((c, s))
        w, dw, a, U = motion[row.parent]
        px, py, pz = row.shift
        gx, gy, gz = (a[k] + U[3 * k] * px + U[3 * k + 1] * py + U[3 * k + 2] * pz for k in range(3))
        (x, y, z), (dx, dy, dz), (ax, ay, az) = (_out(row.fixed, c, s, one) for one in (w, dw, (gx, gy, gz)))
        if row.slides:
            ax, ay, az = ax + y * (v + v), ay - x * (v + v), az + dv
        else:
            dx, dy, dz, z = dx + y * v, dy - x * v, dz + dv, z + v
        x2, y2, z2 = x * x, y * y, z * z
        U = (-(y2 + z2), x * y - dz, x * z + dy, x * y + dz, -(x2 + z2), y * z - dx, x * z - dy, y * z + dx, -(x2 + y2))
        rise = row.rise + p if row.slides else row.rise
        ax, ay, az = ax + U[2] * rise, ay + U[5] * rise, az + U[8] * rise
        motion.append(((x, y, z), (dx, dy, dz), (ax, ay, az), U))
        if row.slides:
            m, hx, hy, hz = row.moments
            f = [m * b + U[3 * k] * hx + U[3 * k + 1] * hy + U[3 * k + 2] * hz for k, b in enumerate((ax, ay, az))]
            n = [hy * az - hz * ay, hz * ax - hx * az, hx * ay - hy * ax]
        else:
            hx, hy, xx, yy, xy, xz, yz = row.moments
            f = [U[3 * k] * hx + U[3 * k + 1] * hy for k in range(3)]
            n = [
                U[6] * xy - U[3] * xz + (z2 - y2) * yz + U[7] * yy + hy * az,
                U[1] * yz - U[7] * xy + (x2 - z2) * xz - U[6] * xx - hx * az,
                U[5] * xz - U[2] * yz + (y2 - x2) * xy + U[3] * xx - U[1] * yy + hx * ay - hy * ax,
            ]
        F.append([*f, *n])
    tau = [zero] * len(table.rows)
    for i in range(len(table.rows), 0, -1):  # inward: what bodies hand on to their parents
        row, (c, s), (X, Y, Z, x, y, z) = table.rows[i - 1], turn[i - 1], F[i]
        tau[i - 1] = (Z if row.slides else z) + row.rotor * qdd[i - 1]
        rise = row.rise + q[i - 1] if row.slides else row.rise
        X, Y, Z = _back(row.fixed, c, s, (X, Y, Z))
        x, y, z = _back(row.fixed, c, s, (F[i][3] - rise * F[i][1], F[i][4] + rise * F[i][0], F[i][5]))
        px, py, pz = row.shift
        x, y, z = x + py * Z - pz * Y, y + pz * X - px * Z, z + px * Y - py * X
        F[row.parent] = [a + b for a, b in zip(F[row.parent], (X, Y, Z, x, y, z), strict=True)]
    return tau


def _out(fixed: tuple[Expr, ...], c: Expr, s: Expr, r: Vec) -> Vec:
    """Return a direction of the parent's frame in the joint's own."""
    x, y, z = r
    if len(fixed) == 2:
        y, z = fixed[0] * y + fixed[1] * z, fixed[0] * z - fixed[1] * y
    else:
        x, y, z = (fixed[k] * r[0] + fixed[3 + k] * r[1] + fixed[6 + k] * r[2] for k in range(3))
    return c * x + s * y, c * y - s * x, z


def _back(fixed: tuple[Expr, ...], c: Expr, s: Expr, r: Vec) -> Vec:
    """Return a direction of the joint's frame in the parent's."""
    x, y, z = c * r[0] - s * r[1], s * r[0] + c * r[1], r[2]
    if len(fixed) == 2:
        return x, fixed[0] * y - fixed[1] * z, fixed[1] * y + fixed[0] * z
    x, y, z = (fixed[3 * k] * x + fixed[3 * k + 1] * y + fixed[3 * k + 2] * z for k in range(3))
    return x, y, z
