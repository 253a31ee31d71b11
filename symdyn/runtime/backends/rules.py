"""How each word is differentiated, in terms of words: the same for every library of arrays.

    f  ->  d f  = J(x) dx                       the word ALONG
    J d          moved along x' is  H(eᵢ) x' · d, entry by entry; linear in d
    wᵀ J         moved along x' is  H(w) x'; linear in w
    J            moved along x' has rows H(eᵢ) x'
    H(w) d       is linear in w and in d; along x it is differentiated as a function like any other

H is symmetric: `stated` ways are those of coordinates whose rates are the velocities, and `plain` ones of numbers.
Backwards the same is read the other way round. Arrays have equal leading dimensions, or 1 where they are broadcast.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import prod
from typing import Any

from symdyn.frozen import dataclass
from symdyn.runtime.backends.words import ALL, ALONG, BACK, BENT, VALUE, DerivativeRule, Word, weights_of

Array = Any
Named = dict[str, Array]


@dataclass(frozen=True)
class Arrays:
    """A library of arrays: its namespace, which follows NumPy's names, and what calls a word with arrays in order."""

    xp: Any
    call: Callable[[Word, Sequence[Array]], Array]

    def word(self, word: Word, given: Mapping[str, Array]) -> Array:
        """Return what a word computes; directions that are not given are zero."""
        some, core = next((given[name], shape) for name, shape in word.arguments if name in given)
        leading = some.ndim - len(core)
        return self.call(
            word,
            [
                given[name] if name in given else self.xp.zeros((1,) * leading + shape, dtype=some.dtype)
                for name, shape in word.arguments
            ],
        )

    def leading(self, word: Word, given: Mapping[str, Array]) -> tuple[int, ...]:
        """Return the dimensions that the arguments of a word broadcast to."""
        found: tuple[int, ...] = ()
        for name, shape in word.arguments:
            if name in given:
                mine = tuple(given[name].shape)[: given[name].ndim - len(shape)]
                found = tuple(b if a == 1 else a for a, b in zip(found or (1,) * len(mine), mine, strict=True))
        return found


def tangent(k: Arrays, word: Word, given: Named, moved: Named) -> Array:
    """Return how a word's result moves with its arguments; `moved` has those that do."""
    base, way = _base(word)
    along = {name: d for name, d in moved.items() if name in base.names}
    linear = {name: d for name, d in moved.items() if name not in base.names}
    if word.kind == VALUE or (word.kind == BENT and along):
        every = word.way_for([*moved])
        return k.word(every.word(ALONG), {**given, **{every.direction(name): d for name, d in moved.items()}})
    assert way is not None, "only values belong to nothing"
    x = {name: given[name] for name in base.names if name in given}
    weights, terms = weights_of(base), []
    if linear and word.kind in (ALONG, BENT):
        steps = {one: d for one, d in linear.items() if one != weights}
        if steps:
            held = {weights: given[weights]} if word.kind == BENT and weights else {}
            terms.append(k.word(word, {**x, **held, **steps}))
        if weights in linear:
            held = {name: d for name, d in given.items() if name not in base.names}
            terms.append(k.word(word, {**x, **held, weights: linear[weights]}))
    elif linear:  # BACK
        terms.append(k.word(word, {**x, weights: linear[weights]}))
    if along and word.kind == BACK:
        held = {weights: given[weights]} if weights else {}
        terms.append(_pick(k, way, *_bent(k, base, [*along], x, held, along)))
    elif along:
        bent, rows = _rows(k, base, [*along, *way.varied_names], x, along)
        if word.kind == ALL:
            found = _pick(k, way, bent, rows)
            terms.append(found.reshape((*found.shape[:-2], *word.shape)))
        else:
            steps = {name: given[way.direction(name)] for name in way.varied_names if way.direction(name) in given}
            terms.append(_times(k, bent, rows, steps))
    return _total(terms)


def cotangent(k: Arrays, word: Word, given: Named, y: Array, requested: Sequence[str]) -> Named:
    """Return the derivatives of the sum of a word's entries, weighed by y, by the arguments that are wanted."""
    base, way = _base(word)
    along = [name for name in requested if name in base.names]
    if word.kind == VALUE or (word.kind == BENT and along):
        every = word.way_for(requested)
        parts = _split(every, _weighed(k, every, given, _flat(y, word) if word.shape else y))
        return {name: part for name, part in parts.items() if name in requested}
    assert way is not None, "only values belong to nothing"
    x = {name: given[name] for name in base.names if name in given}
    weights = weights_of(base)
    found: Named = {}
    held = {weights: given[weights]} if weights and weights in given else {}
    linear = [name for name in requested if name not in base.names]
    steps = {name: given[way.direction(name)] for name in way.varied_names if way.direction(name) in given}
    if word.kind == ALONG:
        flat = _flat(y, base) if weights else y
        if linear:
            pulled = _split(way, _weighed(k, way, x, flat))
            found |= {way.direction(name): part for name, part in pulled.items()}
        if along:
            found |= _bent_back(k, base, along, x, {weights: flat} if weights else {}, steps, None if weights else y)
    elif word.kind == BACK:
        parts = _split(way, y)
        if linear:
            moved = k.word(way.word(ALONG), {**x, **_named(way, parts)})
            found[weights] = _flat(moved, base)
        if along:
            found |= _bent_back(k, base, along, x, held, parts, None)
    elif word.kind == BENT:
        parts = _split(way, y)
        if weights in linear:
            _, rows = _rows(k, base, [*way.varied_names], x, steps, way)
            found[weights] = k.xp.einsum("...mk,...k->...m", rows, y)
        if set(linear) - {weights}:
            pulled = _split(way, k.word(word, {**x, **held, **_named(way, parts)}))
            found |= {way.direction(name): part for name, part in pulled.items()}
    else:  # ALL
        rows = y.reshape((*y.shape[: y.ndim - len(word.shape)], prod(base.shape), way.columns))
        lifted, units = _units(k, base, x)
        pulled = _bent_back(k, base, along, lifted, units, _split(way, k.xp.moveaxis(rows, -2, 0)), None)
        found |= {name: part.sum(0) for name, part in pulled.items()}
    return {name: found[name] for name in requested if name in found}


def all_columns(k: Arrays, way: DerivativeRule, given: Named, moved: Named) -> Array:
    """Return J d as a product with all of J: worth it where many directions share one J."""
    return _times(
        k,
        way,
        whole(k, way, given),
        {n: moved[way.direction(n)] for n in way.varied_names if way.direction(n) in moved},
    )


def all_rows(k: Arrays, way: DerivativeRule, given: Named, weights: Array) -> Array:
    """Return wᵀ J as a product with all of J."""
    return k.xp.einsum("...mk,...m->...k", whole(k, way, given), weights)


def whole(k: Arrays, way: DerivativeRule, given: Named) -> Array:
    """Return J as one matrix a state, (..., m, N)."""
    word = way.word(ALL)
    J = k.word(word, given)
    return J.reshape((*J.shape[: J.ndim - len(word.shape)], prod(way.of.shape), way.columns))


def _times(k: Arrays, way: DerivativeRule, rows: Array, steps: Named) -> Array:
    """Return rows (..., m, N) times directions, with the shape of the function's result."""
    shapes = dict(way.of.arguments)
    blocks = _blocks(way, rows)
    products = [
        k.xp.einsum("...mk,...k->...m", blocks[name], d if shapes[name] else d[..., None]) for name, d in steps.items()
    ]
    found = _total(products)
    return found.reshape((*found.shape[:-1], *way.of.shape))


def _base(word: Word) -> tuple[Word, DerivativeRule | None]:
    """Return the function that a word is a derivative of, and the way between them."""
    return (word, None) if word.way is None else (word.way.of, word.way)


def _flat(array: Array, word: Word) -> Array:
    return array.reshape((*array.shape[: array.ndim - len(word.shape)], prod(word.shape)))


def _weighed(k: Arrays, way: DerivativeRule, x: Named, flat: Array) -> Array:
    """Return yᵀ J, (..., N); of a number, y times its derivatives."""
    weights = weights_of(way.of)
    if weights:
        return k.word(way.word(BACK), {**x, weights: flat})
    return k.word(way.word(BACK), x) * flat[..., None]


def _bent(
    k: Arrays, base: Word, moving: Sequence[str], x: Named, held: Named, moved: Named
) -> tuple[DerivativeRule, Array]:
    """Return H d, and the way whose arguments its entries are of."""
    way = base.way_for(moving)
    return way, k.word(way.word(BENT), {**x, **held, **_named(way, moved)})


def _bent_back(
    k: Arrays, base: Word, along: Sequence[str], x: Named, held: Named, steps: Named, times: Array | None
) -> Named:
    """Return H d by argument, times a number where there are no weights."""
    way, found = _bent(k, base, [*along, *steps], x, held, steps)
    found = found if times is None else found * times[..., None]
    return {name: part for name, part in _split(way, found).items() if name in along}


def _units(k: Arrays, base: Word, x: Named) -> tuple[Named, Named]:
    """Return arguments with one more dimension in front, and weights that are 1 for one entry each along it."""
    lifted = {name: array[None] for name, array in x.items()}
    weights = weights_of(base)
    if not weights:
        return lifted, {}
    some = next(iter(x.items()))
    leading = some[1].ndim - len(dict(base.arguments)[some[0]])
    count = prod(base.shape)
    unit = k.xp.eye(count, dtype=some[1].dtype).reshape((count, *(1,) * leading, count))
    return lifted, {weights: unit}


def _rows(
    k: Arrays, base: Word, moving: Sequence[str], x: Named, moved: Named, way: DerivativeRule | None = None
) -> tuple[DerivativeRule, Array]:
    """Return H(eᵢ) d for every entry i, (..., m, N), and the way whose arguments the columns are of."""
    lifted, units = _units(k, base, x)
    steps = {name: d[None] for name, d in moved.items()}
    way, found = _bent(k, base, moving if way is None else way.varied_names, lifted, units, steps)
    return way, k.xp.moveaxis(found, 0, -2)


def _named(way: DerivativeRule, parts: Named) -> Named:
    return {way.direction(name): d for name, d in parts.items()}


def _blocks(way: DerivativeRule, columns: Array) -> Named:
    found, at = {}, 0
    for name, length in way.varied:
        found[name] = columns[..., at : at + length]
        at += length
    return found


def _split(way: DerivativeRule, columns: Array) -> Named:
    """Return the same as directions: that of one number has no dimension of its own."""
    shapes = dict(way.of.arguments)
    return {name: block if shapes[name] else block[..., 0] for name, block in _blocks(way, columns).items()}


def _pick(k: Arrays, derivative_rule: DerivativeRule, there: DerivativeRule, columns: Array) -> Array:
    """Return the columns of one way among those of another."""
    if derivative_rule.varied == there.varied:
        return columns
    blocks = _blocks(there, columns)
    return k.xp.concatenate([blocks[name] for name in derivative_rule.varied_names], -1)


def _total(terms: Sequence[Array]) -> Array:
    found = terms[0]
    for one in terms[1:]:
        found = found + one
    return found
