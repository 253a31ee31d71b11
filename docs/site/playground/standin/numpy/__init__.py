"""A tiny NumPy in pure Python: what symdyn's pictures, code and lessons ask of it where Python runs in a page."""

import builtins, functools, itertools, math
from math import pi, inf, nan

newaxis = None
__version__ = "0"


class generic:
    pass


class number(generic):
    pass


class floating(number):
    pass


class integer(number):
    pass


class float64(float):
    pass


class bool_(generic):
    pass


class dtype:
    def __class_getitem__(c, k):
        return c


class int64(int):
    pass


class complex128(complex):
    pass


intp = int64
float32 = float64
int8 = int64
object_ = object
complexfloating = complex128


def _prod(s):
    p = 1
    for x in s:
        p *= x
    return p


def _strides(s):
    o = []
    p = 1
    for x in reversed(s):
        o.append(p)
        p *= x
    return o[::-1]


class ndarray:
    __array_priority__ = 1

    def __class_getitem__(c, k):
        return c

    def __init__(s, f, shape):
        s.f = f
        s.shape = tuple(shape)

    ndim = property(lambda s: len(s.shape))
    size = property(lambda s: len(s.f))
    T = property(lambda s: s.transpose())
    dtype = property(lambda s: float64)
    real = property(lambda s: _map(lambda x: x.real if isinstance(x, complex) else x, s))
    flat = property(lambda s: s.f)

    def __len__(s):
        if not s.shape:
            raise TypeError("len of 0-d")
        return s.shape[0]

    def __iter__(s):
        return (s[i] for i in range(len(s)))

    def __float__(s):
        return float(s.f[0])

    def __int__(s):
        return int(s.f[0])

    def __index__(s):
        return int(s.f[0])

    def __bool__(s):
        if len(s.f) != 1:
            raise ValueError("ambiguous truth")
        return bool(s.f[0])

    def __repr__(s):
        return f"array({s.tolist()})"

    def tolist(s):
        if not s.shape:
            return s.f[0]
        n = _prod(s.shape[1:])
        return [ndarray(s.f[i * n : (i + 1) * n], s.shape[1:]).tolist() for i in range(s.shape[0])]

    def item(s, *a):
        return s.f[0] if not a else s[a]

    def copy(s):
        return ndarray(list(s.f), s.shape)

    def astype(s, t=float, copy=True):
        g = {bool: bool, int: int, float: float}.get(t) or (
            int if issubclass(t, int) else complex if issubclass(t, complex) else float
        )
        return ndarray([g(x) for x in s.f], s.shape)

    def reshape(s, *sh):
        sh = tuple(sh[0]) if len(sh) == 1 and isinstance(sh[0], (tuple, list)) else sh
        if -1 in sh:
            k = _prod([x for x in sh if x != -1]) or 1
            sh = tuple(len(s.f) // k if x == -1 else x for x in sh)
        return ndarray(list(s.f), sh)

    def ravel(s):
        return ndarray(list(s.f), (len(s.f),))

    flatten = ravel

    def transpose(s, *ax):
        ax = ax[0] if len(ax) == 1 and isinstance(ax[0], tuple) else ax
        ax = ax or tuple(range(s.ndim))[::-1]
        st = _strides(s.shape)
        sh = [s.shape[a] for a in ax]
        return ndarray(
            [s.f[builtins.sum(i * st[a] for i, a in zip(ix, ax))] for ix in itertools.product(*map(range, sh))], sh
        )

    def swapaxes(s, a, b):
        ax = list(range(s.ndim))
        ax[a], ax[b] = ax[b], ax[a]
        return s.transpose(tuple(ax))

    def _index(s, k):
        k = k if isinstance(k, tuple) else (k,)
        k = tuple(asarray(x) if isinstance(x, (list, range)) else x for x in k)
        used = builtins.sum(
            (x.ndim if isinstance(x, ndarray) and x.f and isinstance(x.f[0], bool) else 1)
            for x in k
            if x is not None and x is not Ellipsis
        )
        if not any_(x is Ellipsis for x in k):
            k = (*k, Ellipsis)
        i = [x is Ellipsis for x in k].index(True)
        k = k[:i] + (slice(None),) * (s.ndim - used) + k[i + 1 :]
        st = _strides(s.shape)
        axis = 0
        parts = []
        adv = []
        offs = []
        for x in k:
            if x is None:
                parts.append([0])
                offs.append(None)
                continue
            if isinstance(x, slice):
                parts.append([j * st[axis] for j in range(*x.indices(s.shape[axis]))])
                offs.append(None)
                axis += 1
            elif isinstance(x, ndarray) and x.ndim and isinstance((x.f or [0])[0], bool):
                sub = _strides(x.shape)
                pick = [
                    builtins.sum(a * b for a, b in zip(ix, st[axis : axis + x.ndim]))
                    for ix, v in zip(itertools.product(*map(range, x.shape)), x.f)
                    if v
                ]
                parts.append(("adv", ndarray(pick, (len(pick),))))
                axis += x.ndim
            elif isinstance(x, ndarray) and x.ndim:
                n = s.shape[axis]
                parts.append(
                    ("adv", ndarray([(int(j) % n if -n <= j < n else _out()) * st[axis] for j in x.f], x.shape))
                )
                axis += 1
            else:
                j = int(x)
                n = s.shape[axis]
                if not -n <= j < n:
                    raise IndexError(f"{j} of {n}")
                parts.append(("int", (j % n) * st[axis]))
                axis += 1
        base = 0
        sh = []
        lists = []
        advs = [p[1] for p in parts if isinstance(p, tuple) and p[0] == "adv"]
        if advs:
            ash = _bshape(*[a.shape for a in advs])
            tot = [0] * _prod(ash)
            for a in advs:
                tot = [u + v for u, v in zip(tot, _bc(a, ash).f)]
        done = False
        for p in parts:
            if isinstance(p, tuple):
                if p[0] == "int":
                    base += p[1]
                elif not done:
                    lists.append(tot)
                    sh += list(ash)
                    done = True
            else:
                lists.append(p)
                sh.append(len(p))
        out = [base]
        for l in lists:
            out = [a + b for a in out for b in l]
        return out, tuple(sh)

    def __getitem__(s, k):
        o, sh = s._index(k)
        r = [s.f[i] for i in o]
        return r[0] if not sh else _View(r, sh, s, o)

    def __setitem__(s, k, v):
        o, sh = s._index(k)
        v = _bc(asarray(v), sh)
        for i, x in zip(o, v.f):
            s.f[i] = x
        s._back()

    def _back(s):
        pass

    def _red(s, g, axis=None, keepdims=False, **k):
        if (
            axis is not None
            and not isinstance(axis, tuple)
            and s.shape[axis] * 0 == 0
            and _prod(s.shape) == 0
            and s.shape[axis] == 0
        ):
            sh = tuple(d for i, d in enumerate(s.shape) if i != axis % s.ndim)
            return ndarray([g([]) for _ in range(_prod(sh))], sh) if sh else g([])
        if axis is None:
            r = g(s.f)
            return r if not keepdims else ndarray([r], (1,) * s.ndim)
        if isinstance(axis, tuple):
            for a in sorted((x % s.ndim for x in axis), reverse=True):
                s = s._red(g, a)
            return s
        axis %= s.ndim
        n = s.shape[axis]
        inner = _prod(s.shape[axis + 1 :])
        outer = _prod(s.shape[:axis])
        f = [g(s.f[o * n * inner + i : (o + 1) * n * inner : inner]) for o in range(outer) for i in range(inner)]
        sh = s.shape[:axis] + ((1,) if keepdims else ()) + s.shape[axis + 1 :]
        return ndarray(f, sh) if sh else f[0]

    def sum(s, axis=None, **k):
        return s._red(builtins.sum, axis, **k)

    def max(s, axis=None, initial=None, **k):
        return s._red(lambda f: builtins.max([*f, *([] if initial is None else [initial])]), axis, **k)

    def min(s, axis=None, initial=None, **k):
        return s._red(lambda f: builtins.min([*f, *([] if initial is None else [initial])]), axis, **k)

    def mean(s, axis=None, **k):
        return s._red(lambda f: builtins.sum(f) / len(f), axis, **k)

    def any(s, axis=None, **k):
        return s._red(builtins.any, axis, **k)

    def all(s, axis=None, **k):
        return s._red(builtins.all, axis, **k)

    def argmax(s, axis=None):
        return s._red(lambda f: f.index(builtins.max(f)), axis)

    def argmin(s, axis=None):
        return s._red(lambda f: f.index(builtins.min(f)), axis)

    def argsort(s, axis=-1, kind=None):
        return argsort(s)

    def round(s, d=0):
        return _map(lambda x: builtins.round(x, d), s)

    def clip(s, a=None, b=None):
        return clip(s, a, b)

    def dot(s, o):
        return s @ o

    def nonzero(s):
        return nonzero(s)

    def fill(s, v):
        s.f[:] = [v] * len(s.f)

    def __matmul__(a, b):
        b = asarray(b)
        a = ndarray(a.f, a.shape)
        one = a.ndim == 1
        two = b.ndim == 1
        if one:
            a = ndarray(a.f, (1, *a.shape))
        if two:
            b = ndarray(b.f, (*b.shape, 1))
        lead = _bshape(a.shape[:-2], b.shape[:-2])
        n, m, p = a.shape[-2], a.shape[-1], b.shape[-1]
        assert m == b.shape[-2], (a.shape, b.shape)
        A = _bc(a, (*lead, n, m)).f
        B = _bc(b, (*lead, m, p)).f
        f = []
        for l in range(_prod(lead)):
            x = l * n * m
            y = l * m * p
            f += [
                builtins.sum(A[x + i * m + k] * B[y + k * p + j] for k in range(m)) for i in range(n) for j in range(p)
            ]
        sh = lead + (() if one else (n,)) + (() if two else (p,))
        return ndarray(f, sh) if sh else f[0]

    def __rmatmul__(s, o):
        return asarray(o) @ s

    def __eq__(a, b):
        return _bin(lambda x, y: x == y, a, b)

    def __ne__(a, b):
        return _bin(lambda x, y: x != y, a, b)

    __hash__ = None

    def __neg__(s):
        return _map(lambda x: -x, s)

    def __abs__(s):
        return _map(builtins.abs, s)

    def __invert__(s):
        if s.f and isinstance(s.f[0], bool):
            return ndarray(list(map(_o.not_, s.f)), s.shape)
        return _map(lambda x: not x if isinstance(x, bool) else ~x, s)


class _View(ndarray):
    def __init__(s, f, sh, base, o):
        ndarray.__init__(s, f, sh)
        s.base = base
        s.o = o

    def _back(s):
        for i, x in zip(s.o, s.f):
            s.base.f[i] = x
        s.base._back()


any_ = builtins.any


def _out():
    raise IndexError


@functools.lru_cache(maxsize=512)
def _bshape(*shapes):
    n = builtins.max(map(len, shapes), default=0)
    o = []
    for k in range(n):
        d = {([1] * (n - len(s)) + list(s))[k] for s in shapes} - {1}
        if len(d) > 1:
            raise ValueError(f"cannot broadcast {shapes}")
        o.append(d.pop() if d else 1)
    return tuple(o)


def _bc(a, sh):
    if a.shape == tuple(sh):
        return a
    if len(a.f) == 1:
        return ndarray(a.f * _prod(sh), sh)
    return ndarray(list(map(a.f.__getitem__, _spread(a.shape, tuple(sh)))), sh)


@functools.lru_cache(maxsize=512)
def _spread(shape, sh):
    """Return where each entry of a shape stands in an array of another that is broadcast to it."""
    s = (1,) * (len(sh) - len(shape)) + shape
    st = [0 if x == 1 else y for x, y in zip(s, _strides(s))]
    if any_(x not in (1, y) for x, y in zip(s, sh)):
        raise ValueError(f"cannot broadcast {shape} to {sh}")
    out = [0]
    for d, t in zip(sh, st):
        out = [o + i * t for o in out for i in range(d)]
    return out


def _sc(x):
    return not isinstance(x, (ndarray, list, tuple))


def _bin(g, a, b):
    if _sc(a) and _sc(b):
        return g(a, b)
    a, b = asarray(a), asarray(b)
    sh = _bshape(a.shape, b.shape)
    r = list(map(g, _bc(a, sh).f, _bc(b, sh).f))
    return ndarray(r, sh) if sh else r[0]


def _map(g, a):
    if _sc(a):
        return g(a)
    a = asarray(a)
    return ndarray(list(map(g, a.f)), a.shape) if a.shape else g(a.f[0])


def _div(x, y):
    try:
        return x / y
    except ZeroDivisionError:
        return nan if x == 0 or x != x else math.copysign(inf, x)


import operator as _o

for _n, _g in {
    "add": _o.add,
    "sub": _o.sub,
    "mul": _o.mul,
    "truediv": _div,
    "floordiv": _o.floordiv,
    "mod": _o.mod,
    "pow": _o.pow,
    "and": _o.and_,
    "or": _o.or_,
    "xor": _o.xor,
}.items():

    def _mk(g):
        def f(a, b):
            return _bin(g, a, b)

        def r(a, b):
            return _bin(g, b, a)

        def i(a, b):
            a[...] = _bin(g, a, b)
            return a

        return f, r, i

    _f, _r, _i = _mk(_g)
    setattr(ndarray, f"__{_n}__", _f)
    setattr(ndarray, f"__r{_n}__", _r)
    setattr(ndarray, f"__i{_n}__", _i)
for _n, _g in {"lt": _o.lt, "le": _o.le, "gt": _o.gt, "ge": _o.ge}.items():
    setattr(ndarray, f"__{_n}__", (lambda g: lambda a, b: _bin(g, a, b))(_g))


def asarray(x, dtype=None, **k):
    if isinstance(x, ndarray):
        r = x
    elif isinstance(x, (list, tuple, range)) or (hasattr(x, "__iter__") and not isinstance(x, (str, bytes, dict))):
        p = [asarray(y) for y in x]
        if not p:
            r = ndarray([], (0,))
        else:
            assert all_(q.shape == p[0].shape for q in p), [q.shape for q in p]
            r = ndarray([v for q in p for v in q.f], (len(p), *p[0].shape))
    else:
        r = ndarray([x], ())
    if dtype is not None and not isinstance(dtype, str) and dtype in (float, float64, int, intp, bool, bool_):
        r = r.astype({bool_: bool}.get(dtype, dtype))
    return r


all_ = builtins.all


def array(x, dtype=None, **k):
    return asarray(x, dtype).copy()


ascontiguousarray = asarray
asanyarray = asarray


def full(sh, v, dtype=None):
    sh = (sh,) if isinstance(sh, int) else tuple(sh)
    return _bc(asarray(v), sh).copy() if sh else asarray(v)


def zeros(sh, dtype=float):
    return full(sh, False if dtype in (bool, bool_) else 0 if dtype in (int, intp) else 0.0)


def ones(sh, dtype=float):
    return full(sh, 1.0)


empty = zeros


def zeros_like(a):
    return zeros(asarray(a).shape)


def full_like(a, v):
    return full(asarray(a).shape, v)


def eye(n, m=None, **k):
    return ndarray([1.0 if i == j else 0.0 for i in range(n) for j in range(m or n)], (n, m or n))


identity = eye


def arange(*a, dtype=None):
    a = (0, *a, 1) if len(a) == 1 else (*a, 1) if len(a) == 2 else a
    n = builtins.max(0, math.ceil((a[1] - a[0]) / a[2]))
    return ndarray([a[0] + i * a[2] for i in range(n)], (n,))


def linspace(a, b, n=50, endpoint=True):
    k = n - 1 if endpoint else n
    return asarray([a + (b - a) * i / k if k else a for i in range(n)])


def broadcast_to(a, sh):
    return _bc(asarray(a), (sh,) if isinstance(sh, int) else tuple(sh))


def broadcast_arrays(*a):
    a = [asarray(x) for x in a]
    sh = _bshape(*[x.shape for x in a])
    return [_bc(x, sh) for x in a]


def concatenate(xs, axis=0):
    xs = [asarray(x) for x in xs]
    axis %= xs[0].ndim
    outer = _prod(xs[0].shape[:axis])
    f = []
    ch = [_prod(x.shape[axis:]) for x in xs]
    for o in range(outer):
        for x, c in zip(xs, ch):
            f += x.f[o * c : (o + 1) * c]
    return ndarray(f, (*xs[0].shape[:axis], builtins.sum(x.shape[axis] for x in xs), *xs[0].shape[axis + 1 :]))


def expand_dims(x, axis):
    x = asarray(x)
    axis %= x.ndim + 1
    return ndarray(x.f, (*x.shape[:axis], 1, *x.shape[axis:]))


def stack(xs, axis=0):
    return concatenate([expand_dims(x, axis) for x in xs], axis)


def atleast_2d(x):
    x = asarray(x)
    return x if x.ndim > 1 else ndarray(x.f, (1, *(x.shape or (1,))))


def atleast_1d(x):
    x = asarray(x)
    return x if x.ndim else ndarray(x.f, (1,))


def vstack(xs):
    return concatenate([atleast_2d(x) for x in xs], 0)


def hstack(xs):
    xs = [asarray(x) for x in xs]
    return concatenate(xs, 0 if xs[0].ndim == 1 else 1)


def split(x, n, axis=0):
    x = asarray(x)
    axis %= x.ndim
    at = [0, *(n if not isinstance(n, int) else [k * x.shape[axis] // n for k in range(1, n)]), x.shape[axis]]
    return [x[(slice(None),) * axis + (slice(a, b),)] for a, b in zip(at, at[1:])]


def repeat(x, n, axis=None):
    x = asarray(x)
    i = asarray([k for k in range(x.shape[axis or 0]) for _ in range(n if isinstance(n, int) else asarray(n).f[k])])
    return x[(slice(None),) * (axis or 0) + (i,)]


def where(c, a=None, b=None):
    if a is None:
        return nonzero(c)
    c, a, b = asarray(c), asarray(a), asarray(b)
    sh = _bshape(c.shape, a.shape, b.shape)
    r = [y if x else z for x, y, z in zip(_bc(c, sh).f, _bc(a, sh).f, _bc(b, sh).f)]
    return ndarray(r, sh) if sh else r[0]


def nonzero(x):
    x = asarray(x)
    ix = [i for i, v in zip(itertools.product(*map(range, x.shape)), x.f) if v]
    return tuple(asarray([i[k] for i in ix]) for k in range(x.ndim))


def flatnonzero(x):
    return asarray([i for i, v in enumerate(asarray(x).f) if v])


def _u(g):
    return lambda x, *a, **k: _map(g, x)


def _nn(g):
    def f(x):
        try:
            return g(x)
        except (ValueError, ZeroDivisionError):
            return nan
        except OverflowError:
            return inf

    return _u(f)


sin, cos, tan, exp, sqrt, log, tanh, arcsin, arccos, arctan, ceil, floor, degrees, radians = map(
    _nn,
    (
        math.sin,
        math.cos,
        math.tan,
        math.exp,
        math.sqrt,
        math.log,
        math.tanh,
        math.asin,
        math.acos,
        math.atan,
        lambda x: float(math.ceil(x)),
        lambda x: float(math.floor(x)),
        math.degrees,
        math.radians,
    ),
)
abs = absolute = _u(builtins.abs)
isfinite = _u(math.isfinite)
isnan = _u(math.isnan)
sign = _u(lambda x: 0.0 if x == 0 else math.copysign(1.0, x))
logical_not = _u(lambda x: not x)
square = _u(lambda x: x * x)


def round(x, d=0):
    return _map(lambda v: builtins.round(v, d), x)


def arctan2(a, b):
    return _bin(math.atan2, a, b)


def power(a, b):
    return _bin(lambda x, y: x**y, a, b)


def hypot(a, b):
    return _bin(math.hypot, a, b)


def maximum(a, b):
    return _bin(builtins.max, a, b)


def minimum(a, b):
    return _bin(builtins.min, a, b)


class _outer:
    pass


def outer(a, b):
    a, b = asarray(a), asarray(b)
    return ndarray([x * y for x in a.f for y in b.f], (a.size, b.size))


def logical_and(a, b):
    return _bin(lambda x, y: bool(x and y), a, b)


def logical_or(a, b):
    return _bin(lambda x, y: bool(x or y), a, b)


def clip(x, a, b):
    x = x if a is None else maximum(x, a)
    return x if b is None else minimum(x, b)


def _m(n):
    return lambda x, *a, **k: getattr(asarray(x), n)(*a, **k)


sum, max, min, mean, any, all, argmax, argmin, transpose, ravel, reshape = (
    _m(n) for n in "sum max min mean any all argmax argmin transpose ravel reshape".split()
)
amax, amin = max, min


def prod(x):
    return _prod(asarray(x).f)


def ptp(x, axis=None):
    return max(x, axis) - min(x, axis)


def shape(x):
    return asarray(x).shape


def ndim(x):
    return asarray(x).ndim


def argsort(x, axis=-1, kind=None):
    x = asarray(x)
    assert x.ndim == 1
    return asarray(sorted(range(len(x.f)), key=x.f.__getitem__))


def sort(x, axis=-1):
    x = asarray(x)
    n = x.shape[-1]
    return ndarray([v for o in range(0, len(x.f), n or 1) for v in sorted(x.f[o : o + n])], x.shape)


def lexsort(ks):
    ks = [asarray(k).f for k in ks]
    return asarray(sorted(range(len(ks[0])), key=lambda i: tuple(k[i] for k in reversed(ks))))


def unique(x, axis=None):
    x = asarray(x)
    if axis is None:
        return asarray(sorted(set(x.f)))
    return asarray([list(r) for r in sorted(set(map(tuple, x.tolist())))])


def triu_indices(n, k=0):
    r = [(i, j) for i in range(n) for j in range(i + k, n)]
    return asarray([a for a, _ in r]), asarray([b for _, b in r])


def tril_indices(n, k=0):
    r = [(i, j) for i in range(n) for j in range(0, i + k + 1)]
    return asarray([a for a, _ in r]), asarray([b for _, b in r])


def isin(a, b):
    b = set(asarray(b).f)
    return _map(lambda x: x in b, a)


def diff(x):
    x = asarray(x)
    return x[1:] - x[:-1]


def diag(x):
    x = asarray(x)
    return (
        ndarray([x.f[i] if i == j else 0.0 for i in range(x.size) for j in range(x.size)], (x.size,) * 2)
        if x.ndim == 1
        else asarray([x[i, i] for i in range(builtins.min(x.shape))])
    )


def trace(x):
    return builtins.sum(asarray(x)[i, i] for i in range(len(x)))


def bincount(x, weights=None, minlength=0):
    x = asarray(x).f
    w = [1] * len(x) if weights is None else asarray(weights).f
    o = [0 if weights is None else 0.0] * builtins.max([minlength, *[int(i) + 1 for i in x]])
    for i, v in zip(x, w):
        o[int(i)] += v
    return asarray(o)


def cross(a, b, axis=-1):
    a, b = asarray(a), asarray(b)
    sh = _bshape(a.shape, b.shape)
    a, b = _bc(a, sh).f, _bc(b, sh).f
    f = []
    for i in range(0, len(a), 3):
        x, y, z = a[i : i + 3]
        u, v, w = b[i : i + 3]
        f += [y * w - z * v, z * u - x * w, x * v - y * u]
    return ndarray(f, sh)


def dot(a, b):
    return asarray(a) @ asarray(b)


def einsum(spec, *ops):
    ins, out = spec.replace(" ", "").split("->")
    ins = ins.split(",")
    ops = [asarray(o) for o in ops]
    lead = (
        _bshape(*[o.shape[: o.ndim - len(i.replace("...", ""))] for i, o in zip(ins, ops) if "..." in i])
        if "..." in spec
        else ()
    )
    big = "ABCDEFGH"[: len(lead)]
    names = []
    for k, (i, o) in enumerate(zip(ins, ops)):
        n = i.replace("...", "")
        l = o.ndim - len(n)
        if "..." in i:
            ops[k] = _bc(o, (*lead, *o.shape[l:]))
            i = i.replace("...", big)
        names.append(i)
    out = out.replace("...", big)
    size = {c: d for i, o in zip(names, ops) for c, d in zip(i, o.shape)}
    rest = [c for c in size if c not in out]
    st = [_strides(o.shape) for o in ops]
    f = []
    for ix in itertools.product(*(range(size[c]) for c in out)):
        e = dict(zip(out, ix))
        t = 0
        for jx in itertools.product(*(range(size[c]) for c in rest)):
            e.update(zip(rest, jx))
            p = 1
            for n, o, s in zip(names, ops, st):
                p *= o.f[builtins.sum(e[c] * k for c, k in zip(n, s))]
            t += p
        f.append(t)
    sh = tuple(size[c] for c in out)
    return ndarray(f, sh) if sh else f[0]


class errstate:
    def __init__(s, **k):
        pass

    def __enter__(s):
        pass

    def __exit__(s, *a):
        pass

    def __call__(s, f):
        return f


def allclose(a, b, rtol=1e-5, atol=1e-8):
    return all(abs(asarray(a) - b) <= atol + rtol * abs(asarray(b)))


def vectorize(f):
    return _u(f)


class finfo:
    def __init__(s, t=float):
        s.resolution = 1e-15
        s.eps = 2.220446049250313e-16
        s.max = 1.7976931348623157e308
        s.tiny = 2.2250738585072014e-308


def _completed(rows, size, count):
    for e in builtins.range(size):
        v = [float(i == e) for i in builtins.range(size)]
        for _ in (0, 1):
            for r in rows:
                c = builtins.sum(x * y for x, y in zip(r, v))
                v = [x - c * y for x, y in zip(v, r)]
        n = math.sqrt(builtins.sum(x * x for x in v))
        if n > 1e-6 and len(rows) < count:
            rows.append([x / n for x in v])
    return rows


class linalg:
    class LinAlgError(ValueError):
        pass

    @staticmethod
    def norm(x, ord=None, axis=None, keepdims=False):
        x = asarray(x)
        if ord == inf:
            return abs(x).max(axis)
        return x._red(lambda f: math.sqrt(builtins.sum(builtins.abs(v) ** 2 for v in f)), axis, keepdims)

    @staticmethod
    def svd(A, full_matrices=True, compute_uv=True):
        A = asarray(A)
        m, n = A.shape
        t = m < n
        W = [list(r) for r in (A if t else A.T).tolist()] if m * n else []
        k = len(W)
        V = [[float(i == j) for j in range(k)] for i in range(k)]
        for _ in range(60):  # one-sided Jacobi on the columns
            big = 0.0
            for p in range(k):
                for q in range(p + 1, k):
                    a = builtins.sum(x * x for x in W[p])
                    b = builtins.sum(x * x for x in W[q])
                    c = builtins.sum(x * y for x, y in zip(W[p], W[q]))
                    if a * b == 0 or builtins.abs(c) <= 1e-16 * math.sqrt(a * b):
                        continue
                    big = builtins.max(big, builtins.abs(c) / math.sqrt(a * b))
                    z = (b - a) / (2 * c)
                    tt = math.copysign(1, z) / (builtins.abs(z) + math.hypot(1, z))
                    co = 1 / math.hypot(1, tt)
                    si = co * tt
                    for M in (W, V):
                        M[p], M[q] = (
                            [co * x - si * y for x, y in zip(M[p], M[q])],
                            [si * x + co * y for x, y in zip(M[p], M[q])],
                        )
            if big < 1e-15:
                break
        s = [math.sqrt(builtins.sum(x * x for x in w)) for w in W]
        o = sorted(range(k), key=lambda i: -s[i])
        if not compute_uv:
            return asarray([s[i] for i in o])
        if not k:
            return eye(m), zeros(0), eye(n)
        U = asarray(
            _completed(
                [[x / s[i] for x in W[i]] for i in o if s[i] > 1e-14 * s[o[0]]],
                len(W[0]),
                len(W[0]) if full_matrices else k,
            )
        )
        VV = asarray([V[i] for i in o])
        S = asarray([s[i] for i in o])
        return (VV.T, S, U) if t else (U.T, S, VV)

    @staticmethod
    def pinv(A, rcond=1e-15):
        if not asarray(A).size:
            return zeros(asarray(A).shape[::-1])
        u, s, v = linalg.svd(A, False)
        return (v.T * asarray([1 / x if x > rcond * s.f[0] else 0.0 for x in s.f])) @ u.T

    @staticmethod
    def lstsq(A, b, rcond=None):
        A = asarray(A)
        r = rcond if rcond is not None else 2.2e-16 * builtins.max(A.shape)
        s = linalg.svd(A, False)[1]
        return linalg.pinv(A, r) @ asarray(b), asarray([]), builtins.sum(x > r * s.f[0] for x in s.f), s

    @staticmethod
    def matrix_rank(A, tol=None):
        s = linalg.svd(A, compute_uv=False)
        t = tol if tol is not None else s.f[0] * builtins.max(asarray(A).shape) * 2.2e-16
        return builtins.sum(x > t for x in s.f)

    @staticmethod
    def solve(A, b):
        A = [list(r) for r in asarray(A).tolist()]
        b = asarray(b)
        B = [[x] if b.ndim == 1 else list(x) for x in b.tolist()]
        n = len(A)
        for i in range(n):
            p = builtins.max(range(i, n), key=lambda r: builtins.abs(A[r][i]))
            A[i], A[p] = A[p], A[i]
            B[i], B[p] = B[p], B[i]
            if A[i][i] == 0:
                raise linalg.LinAlgError("singular")
            for r in range(n):
                if r != i and A[r][i]:
                    q = A[r][i] / A[i][i]
                    A[r] = [x - q * y for x, y in zip(A[r], A[i])]
                    B[r] = [x - q * y for x, y in zip(B[r], B[i])]
        X = [[x / A[i][i] for x in B[i]] for i in range(n)]
        return asarray([x[0] for x in X]) if b.ndim == 1 else asarray(X)

    @staticmethod
    def inv(A):
        return linalg.solve(A, eye(len(A)))


class random:
    @staticmethod
    def default_rng(seed=None):
        raise RuntimeError("called numpy.random")


def tile(x, n):
    x = asarray(x)
    n = (n,) if isinstance(n, int) else tuple(n)
    k = builtins.max(len(n), x.ndim)
    sh = (1,) * (k - x.ndim) + x.shape
    n = (1,) * (k - len(n)) + n
    y = ndarray(list(x.f), sh)
    for a in range(k):
        y = concatenate([y] * n[a], a)
    return y


def _eigh(A):
    A = asarray(A)
    n = len(A)
    a = A.tolist()
    V = [[float(i == j) for j in range(n)] for i in range(n)]
    for _ in range(60):
        off = builtins.sum(a[i][j] ** 2 for i in range(n) for j in range(n) if i != j)
        if off < 1e-30 * (1e-300 + builtins.sum(a[i][i] ** 2 for i in range(n))):
            break
        for p in range(n):
            for q in range(p + 1, n):
                if a[p][q] == 0:
                    continue
                z = (a[q][q] - a[p][p]) / (2 * a[p][q])
                t = math.copysign(1, z) / (builtins.abs(z) + math.hypot(1, z))
                c = 1 / math.hypot(1, t)
                s = c * t
                for k in range(n):
                    a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
                for k in range(n):
                    a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
                for k in range(n):
                    V[k][p], V[k][q] = c * V[k][p] - s * V[k][q], s * V[k][p] + c * V[k][q]
    o = sorted(range(n), key=lambda i: a[i][i])
    return asarray([a[i][i] for i in o]), asarray([[V[k][i] for i in o] for k in range(n)])


linalg.eigh = staticmethod(_eigh)
linalg.eigvalsh = staticmethod(lambda A: _eigh(A)[0])
linalg.det = staticmethod(lambda A: (lambda s: _prod(s.f))(linalg.svd(A, compute_uv=False)))


class uint8(int):
    pass


class uint16(int):
    pass


class int16(int):
    pass


class uint32(int):
    pass


class int32(int):
    pass


class uint64(int):
    pass


class longdouble(float):
    pass


_svd2 = linalg.svd


def _svd(A, full_matrices=True, compute_uv=True):
    A = asarray(A)
    if A.ndim == 2:
        return _svd2(A, full_matrices, compute_uv)
    n = _prod(A.shape[:-2])
    B = A.reshape((n, *A.shape[-2:]))
    r = [_svd2(B[i], full_matrices, compute_uv) for i in range(n)]
    if not compute_uv:
        return stack(r).reshape((*A.shape[:-2], r[0].size))
    return tuple(stack([x[k] for x in r]).reshape((*A.shape[:-2], *r[0][k].shape)) for k in range(3))


linalg.svd = staticmethod(_svd)


def quantile(x, q):
    f = sorted(asarray(x).f)
    h = (len(f) - 1) * q
    i = int(h)
    j = builtins.min(i + 1, len(f) - 1)
    return f[i] + (h - i) * (f[j] - f[i])


def gradient(y, x=None):
    y = asarray(y).f
    n = len(y)
    if x is None:
        x = 1.0
    if _sc(x):
        h = x
        return asarray(
            [(y[1] - y[0]) / h] + [(y[i + 1] - y[i - 1]) / (2 * h) for i in range(1, n - 1)] + [(y[-1] - y[-2]) / h]
        )
    x = asarray(x).f
    o = [(y[1] - y[0]) / (x[1] - x[0])]
    for i in range(1, n - 1):
        a = x[i] - x[i - 1]
        b = x[i + 1] - x[i]
        o.append(-b / (a * (a + b)) * y[i - 1] + (b - a) / (a * b) * y[i] + a / (b * (a + b)) * y[i + 1])
    return asarray(o + [(y[-1] - y[-2]) / (x[-1] - x[-2])])


def argwhere(x):
    x = asarray(x)
    return asarray([list(i) for i, v in zip(itertools.product(*map(range, x.shape)), x.f) if v])


def ix_(*a):
    n = len(a)
    return tuple(asarray(x).reshape((1,) * k + (-1,) + (1,) * (n - 1 - k)) for k, x in enumerate(a))


def roots(p):
    p = [complex(x) for x in asarray(p).f]
    while p and p[0] == 0:
        p.pop(0)
    n = len(p) - 1
    z = [(0.4 + 0.9j) ** k for k in range(n)]
    for _ in range(500):
        m = 0
        for i in range(n):
            v = 0
            for c in p:
                v = v * z[i] + c
            w = p[0]
            for j in range(n):
                if j != i:
                    w *= z[i] - z[j]
            d = v / w
            z[i] -= d
            m = builtins.max(m, builtins.abs(d))
        if m < 1e-15:
            break
    return asarray([x if builtins.abs(x.imag) > 1e-13 * (1 + builtins.abs(x)) else complex(x.real, 0) for x in z])


def isclose(a, b, rtol=1e-5, atol=1e-8):
    return abs(asarray(a) - b) <= atol + rtol * abs(asarray(b))


def count_nonzero(x):
    return builtins.sum(1 for v in asarray(x).f if v)


def nan_to_num(x, **k):
    return _map(lambda v: 0.0 if v != v else v, x)


def block(rows):
    rows = [r if isinstance(r, list) else [r] for r in rows]
    return vstack([concatenate([atleast_2d(x) for x in r], -1) for r in rows])


def cumsum(x):
    return asarray(list(itertools.accumulate(asarray(x).f)))


def interp(t, x, y):
    x, y = asarray(x).f, asarray(y).f
    import bisect

    def g(v):
        if v <= x[0]:
            return y[0]
        if v >= x[-1]:
            return y[-1]
        i = bisect.bisect_right(x, v) - 1
        return y[i] + (v - x[i]) / (x[i + 1] - x[i]) * (y[i + 1] - y[i])

    return _map(g, t)


class _Generator:
    def __init__(s, seed=0):
        import random as _random

        s.g = _random.Random(seed if isinstance(seed, (int, str)) else 0)

    def _made(s, draw, size):
        if size is None:
            return draw()
        size = (size,) if isinstance(size, int) else tuple(size)
        return ndarray([draw() for _ in builtins.range(_prod(size))], size)

    def uniform(s, low=0.0, high=1.0, size=None):
        return s._made(lambda: s.g.uniform(low, high), size)

    def normal(s, loc=0.0, scale=1.0, size=None):
        return s._made(lambda: s.g.gauss(loc, scale), size)

    def standard_normal(s, size=None):
        return s.normal(0.0, 1.0, size)

    def random(s, size=None):
        return s._made(s.g.random, size)


class random:
    default_rng = _Generator
