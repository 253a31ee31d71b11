"""Placement of a joint's frame in its parent's, factored so that nothing is multiplied out.

    T = shift · fixed turns · turn of the joint · rise along z

    shift     origin of the joint in the parent's frame; along x alone where the frames allow it, m
    fixed     constant turns, none or one about x on a chain
    turn      about z, by the joint's angle (revolute) or a constant one (prismatic)
    rise      along z afterwards, by a constant (revolute) or the joint's way (prismatic), m

A turn about a coordinate axis takes a vector for 4 multiplications and 2 additions, and by ±90° for none; a general one
takes 9 and 6. J = Σ m r rᵀ turns about an axis for 8 multiplications, with w = c (J_ii - J_jj) - 2 s J_ij:

    J'_ii = J_jj + c w,    J'_jj = J_ii - c w,    J'_ij = J_ij + s w

H that is not symmetric for 12 in place of 24, with w = c (H_ii - H_jj) - s (H_ij + H_ji) and H'_ji = H_ji + s w.

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), sections 3.2 and 3.3, 9.6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from symdyn.dynamics.recursive.moments import Moments, TurnedMoments
from symdyn.graph import Expr
from symdyn.spatial import Mat, Transform, Vec, zero_vector


class Turn(Protocol):
    """A rotation R of a frame."""

    def out(self, x: Vec) -> Vec:
        """Return Rᵀ x: a vector of the parent's frame in the turned one."""

    def back(self, x: Vec) -> Vec:
        """Return R x: a vector of the turned frame in the parent's."""

    def tensor_back(self, J: Mat) -> Mat:
        """Return R J Rᵀ for a symmetric J."""

    def block_back(self, H: Mat) -> Mat:
        """Return R H Rᵀ for any H."""


@dataclass(frozen=True)
class PlanarTurn:
    """A turn about a coordinate axis k (0, 1, 2) by the angle with this cosine and sine."""

    k: int
    cos: Expr
    sin: Expr

    def out(self, x: Vec) -> Vec:
        """Return Rᵀ x."""
        return self._turn(x, -self.sin)

    def back(self, x: Vec) -> Vec:
        """Return R x."""
        return self._turn(x, self.sin)

    def _turn(self, x: Vec, s: Expr) -> Vec:
        i, j, c = (self.k + 1) % 3, (self.k + 2) % 3, self.cos
        turned = list(x)
        turned[i], turned[j] = c * x[i] - s * x[j], s * x[i] + c * x[j]
        return (turned[0], turned[1], turned[2])

    def after(self, first: PlanarTurn) -> PlanarTurn:
        """Return both turns in one, about the same axis: the sine and cosine of a sum of angles."""
        c, s = self.cos, self.sin
        return PlanarTurn(self.k, c * first.cos - s * first.sin, s * first.cos + c * first.sin)

    def tensor_back(self, J: Mat) -> Mat:
        """Return R J Rᵀ for a symmetric J."""
        k, i, j, c, s = self.k, (self.k + 1) % 3, (self.k + 2) % 3, self.cos, self.sin
        rows = [list(row) for row in J]
        if c.is_zero:
            rows[i][i], rows[j][j], rows[i][j] = J[j][j], J[i][i], -J[i][j]
        elif not s.is_zero:
            w = c * (J[i][i] - J[j][j]) - s * (J[i][j] * 2)
            rows[i][i], rows[j][j], rows[i][j] = J[j][j] + c * w, J[i][i] - c * w, J[i][j] + s * w
        rows[i][k], rows[j][k] = c * J[k][i] - s * J[k][j], s * J[k][i] + c * J[k][j]
        rows[j][i], rows[k][i], rows[k][j] = rows[i][j], rows[i][k], rows[j][k]
        return Mat.symmetric(rows[0][0], rows[1][1], rows[2][2], rows[0][1], rows[0][2], rows[1][2])

    def block_back(self, H: Mat) -> Mat:
        """Return R H Rᵀ for any H: two by two as J is, the rest by columns and rows."""
        k, i, j, c, s = self.k, (self.k + 1) % 3, (self.k + 2) % 3, self.cos, self.sin
        rows = [list(row) for row in H]
        a, b, d, e = H[i][i], H[i][j], H[j][i], H[j][j]
        if c.is_zero:
            rows[i][i], rows[i][j], rows[j][i], rows[j][j] = e, -d, -b, a
        elif not s.is_zero:
            w = c * (a - e) - s * (b + d)
            rows[i][i], rows[i][j], rows[j][i], rows[j][j] = e + c * w, b + s * w, d + s * w, a - c * w
        rows[i][k], rows[j][k] = c * H[i][k] - s * H[j][k], s * H[i][k] + c * H[j][k]
        rows[k][i], rows[k][j] = c * H[k][i] - s * H[k][j], s * H[k][i] + c * H[k][j]
        return Mat((x, y, z) for x, y, z in rows)

    def moments_back(self, body: Moments) -> Moments:
        """Return the moments of a body that this turns, about z."""
        return TurnedMoments(body.m, self.back(body.h), self.tensor_back(body.J), body)


@dataclass(frozen=True)
class GeneralTurn:
    """Any rotation, by its matrix."""

    R: Mat

    def out(self, x: Vec) -> Vec:
        """Return Rᵀ x."""
        return self.R.T @ x

    def back(self, x: Vec) -> Vec:
        """Return R x."""
        return self.R @ x

    def tensor_back(self, J: Mat) -> Mat:
        """Return R J Rᵀ for a symmetric J."""
        return self.block_back(J).mirrored()

    def block_back(self, H: Mat) -> Mat:
        """Return R H Rᵀ for any H."""
        return self.R @ H @ self.R.T


@dataclass(frozen=True)
class Link:
    """A factored placement; see the module's legend."""

    shift: Vec
    fixed: tuple[Turn, ...]
    turn: PlanarTurn
    rise: Expr

    @property
    def turns(self) -> tuple[Turn, ...]:
        """All turns, the parent's side first."""
        return (*self.fixed, self.turn)

    @property
    def axis(self) -> Vec:
        """The link's z axis in the parent's frame."""
        zero = self.rise.graph.zero
        axis: Vec = (zero, zero, self.rise.graph.one)
        for turn in reversed(self.fixed):
            axis = turn.back(axis)
        return axis

    @property
    def is_right(self) -> bool:
        """Whether the link's z axis is an axis of the parent's frame."""
        return sum(x.is_zero for x in self.axis) == 2

    def out(self, x: Vec) -> Vec:
        """Return a direction of the parent's frame in the link's own."""
        for turn in self.turns:
            x = turn.out(x)
        return x

    def back(self, x: Vec) -> Vec:
        """Return a direction of the link's frame in the parent's."""
        for turn in reversed(self.turns):
            x = turn.back(x)
        return x

    def wrench_back(self, n: Vec, f: Vec) -> tuple[Vec, Vec]:
        """Return a wrench (moment about the link's origin, force) about the parent's origin, in its frame."""
        n = self.back((n[0] - self.rise * f[1], n[1] + self.rise * f[0], n[2]))
        f = self.back(f)
        x, y, z = self.shift
        n = (n[0] + y * f[2] - z * f[1], n[1] + z * f[0] - x * f[2], n[2] + x * f[1] - y * f[0])
        return n, f

    def moments_back(self, body: Moments) -> Moments:
        """Return the moments of a body of the link's frame in the parent's."""
        zero = self.rise.graph.zero
        body = body.shifted((zero, zero, self.rise))
        h, J = body.h, body.J
        for turn in reversed(self.turns):
            h, J = turn.back(h), turn.tensor_back(J)
        return Moments(body.m, h, J).shifted(self.shift)

    def at_rest(self, slides: bool) -> Link:
        """Return the link without the motion of its joint, for what the motion leaves as it is."""
        graph = self.rise.graph
        if slides:
            return Link(self.shift, self.fixed, self.turn, graph.zero)
        return Link(self.shift, self.fixed, PlanarTurn(2, graph.one, graph.zero), self.rise)

    @property
    def transform(self) -> Transform:
        """The placement multiplied out."""
        graph = self.rise.graph
        one, zero = graph.one, graph.zero
        columns = [self.back(e) for e in ((one, zero, zero), (zero, one, zero), (zero, zero, one))]
        R = Mat(columns).T
        rise = self.back((zero, zero, self.rise)) if not self.rise.is_zero else zero_vector(graph)
        p = (self.shift[0] + rise[0], self.shift[1] + rise[1], self.shift[2] + rise[2])
        return Transform(R, p)
