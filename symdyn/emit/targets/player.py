"""What calls the functions of a NumPy module: operands are checked, a batch goes in blocks through one work space.

All below the two classes stands in every module as it is here, but for the number type and the states of a block, which
`player_text` writes; the classes of a module hold the mathematical functions that it uses.
"""

import collections
import functools
import math

import numpy


class _Floats:
    """Functions of plain floats."""


class _Arrays:
    """The same functions of arrays."""


def _run(compute, name, shape, out, *arguments):
    """Return the entries that `compute` gives, as an array of the leading dimensions and `shape`."""
    arrays = []
    for argument, value, length in arguments:
        array = numpy.asarray(value)
        if array.dtype != numpy.float64:
            if not numpy.can_cast(array.dtype, numpy.float64, "same_kind"):
                raise TypeError(f"{name}: {argument} has type {array.dtype}; give real numbers")
            array = array.astype(numpy.float64)
        if array.shape[-1:] != (length,):
            found = f"{name}: {argument} has shape {array.shape}"
            raise ValueError(f"{found}; its last dimension must have length {length}")
        arrays.append(array)
    batch = _batch(name, arrays, arguments)
    if out is not None:
        _check_out(name, out, batch + shape)
    result = _one(compute, arrays, shape) if batch == () else None
    if result is None:
        result = numpy.empty(batch + shape, dtype=numpy.float64)
        rows = result.reshape(math.prod(batch), math.prod(shape))
        if not 0 < len(rows) <= 16 or not _few(compute, arrays, batch, rows):
            _blocks(compute, arrays, batch, rows)
    if out is None:
        return result[()]
    out[...] = result
    return out


def _check_out(name, out, shape):
    """Raise TypeError or ValueError where a result of this shape cannot be put into `out` as it is."""
    if not isinstance(out, numpy.ndarray):
        raise TypeError(f"{name}: out is a {type(out).__name__}; give an array of shape {shape}")
    if not numpy.can_cast(numpy.float64, out.dtype, "same_kind"):
        raise TypeError(f"{name}: out has type {out.dtype}; it must hold float64")
    if out.shape != shape:
        raise ValueError(f"{name}: out has shape {out.shape}; it must have shape {shape}")
    if not out.flags.writeable:
        raise ValueError(f"{name}: out is read-only; give an array that can be written to")


def _batch(name, arrays, arguments):
    """Return the leading dimensions that all arguments broadcast to."""
    batches = [array.shape[:-1] for array in arrays]
    found = {batch for batch in batches if batch}
    if len(found) < 2:
        return found.pop() if found else ()
    try:
        return numpy.broadcast_shapes(*batches)
    except ValueError:
        names = ", ".join(argument for argument, _, _ in arguments)
        raise ValueError(f"{name}: leading dimensions {batches} of {names} do not broadcast") from None


def _one(compute, arrays, shape):
    """Return the result for one state; None where Python raises what is NaN or infinity in NumPy."""
    try:
        entries = compute(_Floats, *[array.tolist() for array in arrays])
    except (ArithmeticError, ValueError):
        return None
    return numpy.fromiter(entries, numpy.float64).reshape(shape)


def _few(compute, arrays, batch, results):
    """Put the result of every state into its row, one after the other; tell whether Python's floats can do it."""
    count = len(results)
    states = []
    for a in arrays:
        whole = a if a.shape[:-1] == batch or a.ndim == 1 else numpy.broadcast_to(a, batch + a.shape[-1:])
        states.append([a.tolist()] * count if a.ndim == 1 else whole.reshape(count, a.shape[-1]).tolist())
    try:
        rows = [compute(_Floats, *state) for state in zip(*states, strict=True)]
    except (ArithmeticError, ValueError):
        return False
    results[...] = rows
    return True


def _blocks(compute, arrays, batch, results):
    """Put the result of every state into its row, 4096 states at a time, all through one work space."""
    count = len(results)
    flat = [
        a if a.ndim == 1 else numpy.broadcast_to(a, batch + a.shape[-1:]).reshape(count, a.shape[-1]) for a in arrays
    ]
    tape = _record(compute, tuple((a.shape[-1], a.ndim > 1) for a in flat))
    shared = [numpy.empty((), numpy.float64) if number is None else number for number in tape.shared]
    with numpy.errstate(all="ignore"):
        for place, argument, entry in tape.given:
            shared[place] = flat[argument][entry, ...]
        _play(tape.once, shared)
        work = numpy.empty((tape.rows, min(4096, count)), numpy.float64)
        for start in range(0, count, 4096):
            here = slice(start, start + 4096)
            places = [*shared, *work[:, : count - start]]
            for place, argument, entry in tape.read:
                places[place][...] = flat[argument][here, entry]
            _play(tape.each, places)
            for column, place in enumerate(tape.results):
                results[here, column] = places[place]


def _play(calls, places):
    """Make the calls of a tape: call(first, second, result), or call(first, result)."""
    for call, first, second, result in calls:
        if second is None:
            call(places[first], places[result])
        else:
            call(places[first], places[second], places[result])


_Tape = collections.namedtuple("_Tape", "shared given read once each results rows")
"""What a function asks of NumPy, and the places where operands and results stand: first numbers, then rows of states.

    shared       numbers that all states have in common: constants, and None for what a call brings or computes
    given, read  (place, argument, entry) of the numbers that a call brings, and of the rows that a block starts with
    once, each   the calls for what all states have in common, and for what differs, as `_play` takes them
    results      places of the entries of the result
    rows         how many there are; that of a value no longer needed is used again while it is near in the cache
"""


@functools.cache
def _record(compute, arguments):
    """Return the tape of a function; `arguments` says of each how long it is and whether it differs by state."""
    lines = []
    inputs = [[_Value(lines, differs) for _ in range(length)] for length, differs in arguments]
    entries = [_value(lines, entry) for entry in compute(_Arrays, *inputs)]
    for entry in entries:
        entry.last = len(lines)
    shared, given, read, once, each, free = [], [], [], [], [], []
    for value in (*(x for _, operands, result in lines for x in (*operands, result)), *entries):
        if not value.differs and value.place is None:
            value.place = len(shared)
            shared.append(value.number)
    end = len(shared)
    for argument, values in enumerate(inputs):
        for entry, value in enumerate(values):
            if value.last is not None and value.differs:
                value.place, end = end, end + 1
                read.append((value.place, argument, entry))
            elif value.last is not None:
                given.append((value.place, argument, entry))
    for number, (call, operands, result) in enumerate(lines):
        free += dict.fromkeys(x.place for x in operands if x.differs and x.last == number)
        if result.differs and free:
            result.place = free.pop()
        elif result.differs:
            result.place, end = end, end + 1
        places = [*(x.place for x in operands), None][:2]
        (each if result.differs else once).append((call, *places, result.place))
    return _Tape(shared, given, read, once, each, [entry.place for entry in entries], end - len(shared))


class _Value(numpy.lib.mixins.NDArrayOperatorsMixin):
    """Stands for an array while a function is recorded: NumPy hands it the calls that it is in, each becomes a line."""

    def __init__(self, lines, differs, number=None):
        self.lines, self.differs, self.number = lines, differs, number
        self.last = self.place = None

    def __array_ufunc__(self, call, method, *operands):
        operands = [_value(self.lines, x) for x in operands]
        for x in operands:
            x.last = len(self.lines)
        result = _Value(self.lines, any(x.differs for x in operands))
        self.lines.append((call, operands, result))
        return result


def _value(lines, x):
    """Return `x`, a constant as a value that all states share."""
    return x if isinstance(x, _Value) else _Value(lines, False, numpy.array(x, numpy.float64))
