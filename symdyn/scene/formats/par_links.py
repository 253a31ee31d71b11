"""The ten inertial parameters of a link about the origin of its frame, moved there exactly from a body frame.

With R and p the rotation and place of the body frame in the link frame, m, h and I those of the body about its origin:

    M = m      MS = R h + m p      J = R I Rᵀ + 2 (p·Rh) 1 - p (Rh)ᵀ - (Rh) pᵀ + m (p·p 1 - p pᵀ)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.scene.values import folding
from symdyn.scene.values.body import Body
from symdyn.scene.values.quantity import NULL, Quantity, Vector
from symdyn.scene.values.turns import Step, cosine_and_sine

INERTIAL = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")

Matrix = list[list[Quantity]]


@dataclass(frozen=True)
class Link:
    """Inertial parameters as a parameter file names them; kg, kg m, kg m^2."""

    XX: Quantity = Quantity.ZERO
    XY: Quantity = Quantity.ZERO
    XZ: Quantity = Quantity.ZERO
    YY: Quantity = Quantity.ZERO
    YZ: Quantity = Quantity.ZERO
    ZZ: Quantity = Quantity.ZERO
    MX: Quantity = Quantity.ZERO
    MY: Quantity = Quantity.ZERO
    MZ: Quantity = Quantity.ZERO
    M: Quantity = Quantity.ZERO


NOTHING = Link()


def link(body: Body, steps: Sequence[Step]) -> Link:
    """Return the parameters of a body, whose frame is placed in the link frame by steps.

    Args:
        body: with extended mass and particles.
        steps: from the link frame to the body frame.
    """
    mass, moment, inertia = _about_frame(body)
    for kind, amount in reversed(steps):
        axis = "xyz".index(kind[1])
        if kind[0] == "R":
            moment, inertia = _turned(axis, amount, moment, inertia)
        else:
            place = _along(axis, amount)
            inertia = _sum(inertia, _coupled(place, moment), _point(mass, place))
            moment = _plus(moment, _scaled(mass, place))
    return Link(
        XX=inertia[0][0], XY=inertia[0][1], XZ=inertia[0][2], YY=inertia[1][1], YZ=inertia[1][2], ZZ=inertia[2][2],
        MX=moment[0], MY=moment[1], MZ=moment[2], M=mass,
    )  # fmt: skip


def _about_frame(body: Body) -> tuple[Quantity, Vector, Matrix]:
    """Return mass, first moment and inertia of everything on the body about the origin of its frame."""
    xx, yy, zz, xy, xz, yz = body.inertia
    mass, inertia = body.mass, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    moment = body.first_moment or _scaled(mass, body.com or NULL)
    if body.about == "com":
        assert body.com is not None, "a first moment goes with an inertia about the frame"
        inertia = _sum(inertia, _point(mass, body.com))
    for particle in body.particles:
        mass = folding.add(mass, particle.mass)
        moment = _plus(moment, _scaled(particle.mass, particle.at))
        inertia = _sum(inertia, _point(particle.mass, particle.at))
    return mass, moment, inertia


def _turned(axis: int, angle: Quantity, moment: Vector, inertia: Matrix) -> tuple[Vector, Matrix]:
    rotation = _rotation(axis, angle)
    turned = _times(rotation, [[x] for x in moment])
    transposed = [list(column) for column in zip(*rotation, strict=True)]
    full = _times(_times(rotation, inertia), transposed)
    for i in range(3):
        for j in range(i):
            full[i][j] = full[j][i]  # equal, in another order of terms
    return (turned[0][0], turned[1][0], turned[2][0]), full


def _rotation(axis: int, angle: Quantity) -> Matrix:
    c, s = cosine_and_sine(angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix = [[Quantity.ONE if a == b else Quantity.ZERO for b in range(3)] for a in range(3)]
    matrix[j][j], matrix[j][k], matrix[k][j], matrix[k][k] = c, folding.neg(s), s, c
    return matrix


def _point(mass: Quantity, place: Vector) -> Matrix:
    """Return m (p·p 1 - p pᵀ)."""
    x, y, z = place

    def of(a: Quantity, b: Quantity) -> Quantity:
        return folding.mul(mass, folding.mul(a, b))

    xx, yy, zz = of(x, x), of(y, y), of(z, z)
    xy, xz, yz = folding.neg(of(x, y)), folding.neg(of(x, z)), folding.neg(of(y, z))
    return [
        [folding.add(yy, zz), xy, xz],
        [xy, folding.add(xx, zz), yz],
        [xz, yz, folding.add(xx, yy)],
    ]


def _coupled(place: Vector, moment: Vector) -> Matrix:
    """Return 2 (p·h) 1 - p hᵀ - h pᵀ."""
    outer = [[folding.mul(a, b) for b in moment] for a in place]
    half = folding.add(folding.add(outer[0][0], outer[1][1]), outer[2][2])
    double = folding.mul(Quantity.number(2), half)
    return [
        [
            folding.sub(
                double if i == j else Quantity.ZERO,
                folding.add(outer[min(i, j)][max(i, j)], outer[max(i, j)][min(i, j)]),
            )
            for j in range(3)
        ]
        for i in range(3)
    ]


def _along(axis: int, amount: Quantity) -> Vector:
    x, y, z = (amount if k == axis else Quantity.ZERO for k in range(3))
    return x, y, z


def _scaled(factor: Quantity, vector: Vector) -> Vector:
    x, y, z = (folding.mul(factor, part) for part in vector)
    return x, y, z


def _plus(a: Vector, b: Vector) -> Vector:
    x, y, z = (folding.add(p, q) for p, q in zip(a, b, strict=True))
    return x, y, z


def _sum(*matrices: Matrix) -> Matrix:
    total = matrices[0]
    for matrix in matrices[1:]:
        total = [[folding.add(a, b) for a, b in zip(x, y, strict=True)] for x, y in zip(total, matrix, strict=True)]
    return total


def _times(a: Matrix, b: Matrix) -> Matrix:
    return [[_dot(row, [line[j] for line in b]) for j in range(len(b[0]))] for row in a]


def _dot(a: Sequence[Quantity], b: Sequence[Quantity]) -> Quantity:
    total = Quantity.ZERO
    for x, y in zip(a, b, strict=True):
        total = folding.add(total, folding.mul(x, y))
    return total
