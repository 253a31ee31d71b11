"""Motion of one frame after the other along factored links, ground to tips.

    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of the frame, in its axes
    U           [ω̇]× + [ω]× [ω]×: a + U r is the acceleration of a point r of the body

A turn about z leaves U z as it is in space, so that U is found from that column, ω and the last entry of ω̇.

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.91); the matrix U
after Balafoutis and Patel, Dynamic Analysis of Robot Manipulators (1991), section 5.4.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.recursive.links import Link, PlanarTurn
from symdyn.graph import Expr, Op
from symdyn.spatial import Mat, Vec, add, scale


@dataclass(frozen=True)
class LinkMotion:
    """Motion of one frame, in its own axes; see the module's legend. rad/s, rad/s^2, m/s^2.

    Attributes:
        w, dw, a, U: as in the legend.
        squares: ωx², ωy², ωz².
        spread: ωz² - ωy², ωx² - ωz², ωy² - ωx².
        foot: of a run of parallel axes, where ω and U z are short where the run begins: both, and the turn from there.
    """

    w: Vec
    dw: Vec
    a: Vec
    U: Mat
    squares: Vec
    spread: Vec
    foot: tuple[Vec, Vec, PlanarTurn] | None = None


def moving(w: Vec, dw: Vec, a: Vec) -> LinkMotion:
    """Return a motion with its U: six products of ω, nine entries."""
    x, y, z = w
    return with_products(w, (x * x, y * y, z * z, x * y, x * z, y * z), dw, a)


def with_products(w: Vec, products: Sequence[Expr], dw: Vec, a: Vec) -> LinkMotion:
    """Return a motion with its U, for ωx², ωy², ωz², ωx ωy, ωx ωz, ωy ωz."""
    (dx, dy, dz), (xx, yy, zz, xy, xz, yz) = dw, products
    U = Mat(
        (
            (-(yy + zz), xy - dz, xz + dy),
            (xy + dz, -(xx + zz), yz - dx),
            (xz - dy, yz + dx, -(xx + yy)),
        )
    )
    return LinkMotion(w, dw, a, U, (xx, yy, zz), (zz - yy, xx - zz, yy - xx))


def turning(w: Vec, dz: Expr, a: Vec, column: Vec, ends: bool, plane: tuple[Expr, Expr] | None = None) -> LinkMotion:
    """Return a motion with its U from U z, the `column`: that gives ωy² and the rest of ω̇ without a multiplication.

    The last entry of ω̇ is dz; `ends` tells that nobody needs the others. `plane` is ωx², ωy² where both are known.
    """
    x, y, z = w

    def twice() -> Iterator[Expr]:
        double = z * 2
        yield x * double
        yield y * double

    return turning_with(w, (x * x, z * z, x * y, x * z, y * z), twice, dz, a, column, ends, plane)


def turning_with(
    w: Vec,
    products: Sequence[Expr],
    twice: Callable[[], Iterable[Expr]],
    dz: Expr,
    a: Vec,
    column: Vec,
    ends: bool,
    plane: tuple[Expr, Expr] | None = None,
) -> LinkMotion:
    """Return the same for ωx², ωz², ωx ωy, ωx ωz, ωy ωz; `twice` gives the last two doubled, if they are wanted."""
    xx, zz, xy, xz, yz = products
    dx, dy = yz - column[1], column[0] - xz
    zx, zy = (a - b for a, b in zip(twice(), column[:2], strict=True)) if ends else (xz - dy, yz + dx)
    across, yy = -(xx + zz), -column[2] - xx if plane is None else plane[1]
    if plane is None:
        along = column[2] + (xx - zz)
        spread = (column[2] - across, xx - zz, across - along)
    else:
        along, spread = -(yy + zz), (zz - yy, xx - zz, yy - xx)
    U = Mat(
        (
            (along, xy - dz, column[0]),
            (xy + dz, across, column[1]),
            (zx, zy, column[2]),
        )
    )
    return LinkMotion(w, (dx, dy, dz), a, U, (xx, yy, zz), spread)


def carried(
    parent: LinkMotion,
    link: Link,
    slides: bool,
    qd: Expr,
    qdd: Expr,
    ends: bool,
    summing: bool = False,
    alone: bool = False,
    bare: bool = False,
) -> LinkMotion:
    """Return the motion of the frame at the end of a link, whose joint moves at q̇ and q̈ along its z axis.

    A turn about z leaves U z as it is in space. Where z is an axis of the parent's frame, U z is a column of the
    parent's U, turned for 4 multiplications; elsewhere ω̇ is turned. `ends` tells that all links beyond are parallel,
    `summing` that ω and U z may pass parallel axes in one turn by the sum of their angles, `alone` that ω may even
    where U z vanishes, `bare` that no J is there to ask for differences of squares.
    """
    w, dw = link.out(parent.w), link.out(parent.dw)
    a = link.out(add(parent.a, parent.U @ link.shift))
    if slides:
        twice = qd * 2
        moved = moving(w, dw, a)
        a = (a[0] + w[1] * twice, a[1] - w[0] * twice, a[2] + qdd)
    elif link.is_right:
        column, plane = link.out(parent.U @ link.axis), _plane(parent, link)
        foot = _foot(parent, link, alone) if summing else None
        if foot:
            (x, y, _), (u, v, _) = foot[2].out(foot[0]), foot[2].out(foot[1])
            w, column = (x, y, w[2]), (u, v, column[2])
        if bare and plane is None:
            plane = w[0] * w[0], w[1] * w[1]
        moved = replace(turning((w[0], w[1], w[2] + qd), dw[2] + qdd, a, column, ends, plane), foot=foot)
    else:
        moved = moving((w[0], w[1], w[2] + qd), (dw[0] + w[1] * qd, dw[1] - w[0] * qd, dw[2] + qdd), a)
    rise = scale(link.rise, (moved.U[0][2], moved.U[1][2], moved.U[2][2]))
    return replace(moved, a=add(a, rise))


def _foot(parent: LinkMotion, link: Link, alone: bool) -> tuple[Vec, Vec, PlanarTurn] | None:
    """Return ω and U z where a run of parallel axes begins, each with one entry across them, and the turn."""
    if parent.foot and not link.fixed:
        return *parent.foot[:2], parent.foot[2].after(link.turn)
    w, column = parent.w, parent.U @ link.axis
    for turn in link.fixed:
        w, column = turn.out(w), turn.out(column)
    across = [(x.is_zero, y.is_zero) for x, y, _ in (w, column)]
    short = sum(across[0]) == 1 and (sum(across[1]) == 1 or (alone and all(across[1])))
    return (w, column, link.turn) if link.fixed and short else None


def _plane(parent: LinkMotion, link: Link) -> tuple[Expr, Expr] | None:
    """Return ωx², ωy² at the end of a link that does not turn, where its axes are the parent's in another order."""
    if not link.turn.sin.is_zero:
        return None
    x, y, _ = (-one if one.op is Op.NEG else one for one in link.out(parent.squares))
    return (x, y) if x in parent.squares and y in parent.squares else None
