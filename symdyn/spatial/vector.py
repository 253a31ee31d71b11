"""3-vectors and 3x3 matrices over graph nodes: tuples, unrolled, structural zeros fall away at birth."""

from __future__ import annotations

from symdyn.graph import Expr, Graph, Scalar

Vec = tuple[Expr, Expr, Expr]
Mat = tuple[Vec, Vec, Vec]  # rows
Wrench = tuple[Vec, Vec]  # force, moment


def zero_vector(graph: Graph) -> Vec:
    """Return 0."""
    return (graph.zero,) * 3


def identity(graph: Graph) -> Mat:
    """Return the unit matrix."""
    one, zero = graph.one, graph.zero
    return ((one, zero, zero), (zero, one, zero), (zero, zero, one))


def add(a: Vec, b: Vec) -> Vec:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Vec, b: Vec) -> Vec:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def neg(a: Vec) -> Vec:
    """Return -a."""
    return (-a[0], -a[1], -a[2])


def scale(factor: Scalar, a: Vec) -> Vec:
    """Return factor a."""
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def dot(a: Vec, b: Vec) -> Expr:
    """Return a · b."""
    mul, add = a[0].graph.mul, a[0].graph.add  # in half the time of the operators
    return add(add(mul(a[0], b[0]), mul(a[1], b[1])), mul(a[2], b[2]))


def cross(a: Vec, b: Vec) -> Vec:
    """Return a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def skew(a: Vec) -> Mat:
    """Return ã with ã b = a × b, eq. (5.2)."""
    zero = a[0].graph.zero
    return ((zero, -a[2], a[1]), (a[2], zero, -a[0]), (-a[1], a[0], zero))


def transpose(m: Mat) -> Mat:
    """Return mᵀ."""
    return (
        (m[0][0], m[1][0], m[2][0]),
        (m[0][1], m[1][1], m[2][1]),
        (m[0][2], m[1][2], m[2][2]),
    )


def apply(m: Mat, a: Vec) -> Vec:
    """Return m a; most matrices of a mechanism are the unit matrix."""
    if m == identity(a[0].graph):
        return a
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


def apply_transposed(m: Mat, a: Vec) -> Vec:
    """Return mᵀ a."""
    return apply(transpose(m), a)


def multiply(m: Mat, n: Mat) -> Mat:
    """Return m n; most matrices of a mechanism are the unit matrix."""
    unit = identity(m[0][0].graph)
    if unit in (m, n):
        return n if m == unit else m
    columns = transpose(n)
    return (
        (dot(m[0], columns[0]), dot(m[0], columns[1]), dot(m[0], columns[2])),
        (dot(m[1], columns[0]), dot(m[1], columns[1]), dot(m[1], columns[2])),
        (dot(m[2], columns[0]), dot(m[2], columns[1]), dot(m[2], columns[2])),
    )


def add_matrices(m: Mat, n: Mat) -> Mat:
    """Return m + n."""
    return (add(m[0], n[0]), add(m[1], n[1]), add(m[2], n[2]))


def scale_matrix(factor: Scalar, m: Mat) -> Mat:
    """Return factor m."""
    return (scale(factor, m[0]), scale(factor, m[1]), scale(factor, m[2]))


def outer(a: Vec, b: Vec) -> Mat:
    """Return a bᵀ."""
    return (scale(a[0], b), scale(a[1], b), scale(a[2], b))


def rotation(axis: Vec, angle: Expr) -> Mat:
    """Return the rotation by `angle` (rad) about a unit `axis`: R = c 1 + s ã + (1 - c) a aᵀ (Rodrigues).

    Columns are the rotated axes: R takes rotated coordinates to fixed ones. On a coordinate axis the third term
    is written out, so that no 1 - c + c is left behind.
    """
    graph = angle.graph
    s, c, one, zero = graph.sin(angle), graph.cos(angle), graph.one, graph.zero
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        if axis[i] is zero and axis[j] is zero:
            s = s if axis[k] is one else -s
            rows = [[zero] * 3 for _ in range(3)]
            rows[k][k] = one
            rows[i][i], rows[i][j], rows[j][i], rows[j][j] = c, -s, s, c
            return ((*rows[0],), (*rows[1],), (*rows[2],))  # type: ignore[return-value]
    turned = scale_matrix(c, identity(graph))
    return add_matrices(add_matrices(turned, scale_matrix(s, skew(axis))), scale_matrix(one - c, outer(axis, axis)))


def symmetric(xx: Expr, yy: Expr, zz: Expr, xy: Expr, xz: Expr, yz: Expr) -> Mat:
    """Return the symmetric matrix with these entries."""
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
