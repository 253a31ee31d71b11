"""Arguments of public functions: whether one can be taken, by the words of its annotation, and how messages name one.

A kind is a row of `KINDS` or of `OF_KINDS`, or a class that the function's file knows. What an annotation calls by
another name, such as `Entries`, is left to the function, which reads it anyway.
"""

from __future__ import annotations

import ast
import inspect
import os
import re
import sys
from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set, Sized
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, wraps
from operator import index
from types import UnionType
from typing import Any, Protocol, TypeGuard, TypeVar, cast, get_origin

from symdyn.errors import HELD, ArgumentError, SymdynError, choice, hint, listed, names_of, quoted, with_own_names
from symdyn.frozen import dataclass


class SympyExpression(Protocol):
    """An expression of SymPy, in a formula's place."""

    @property
    def free_symbols(self) -> set[Any]:
        """Return its symbols."""


def is_sympy(value: object) -> bool:
    """Tell whether something is of SymPy, which is not imported for that."""
    return any(str(one.__module__).partition(".")[0] == "sympy" for one in type(value).__mro__)


def with_names(value: Any) -> Any:
    """Return a dictionary with names for keys of SymPy, x for x and x(t), x_dot for its rate; all else as it is."""
    if not isinstance(value, dict) or not any(map(is_sympy, value)):
        return value
    names = list[str]()
    for key in value:
        order = getattr(key, "derivative_count", 0)
        names.append(getattr(key.expr if order else key, "name", str(key)) + f"_{'d' * order}ot" * bool(order))
    if twice := [name for name in dict.fromkeys(names) if names.count(name) > 1]:
        raise ArgumentError(f"{listed(twice)}: given twice, as text and as a symbol; leave one out")
    return dict(zip(names, value.values(), strict=True))


def is_function(value: Any) -> TypeGuard[Callable[..., Any]]:
    """Tell whether something can be called, and not only to be told what works in its place, as nouns of ours can."""
    said = getattr(type(value).__call__, "__annotations__", {}) if callable(value) else {"return": "NoReturn"}
    return said.get("return") != "NoReturn" or (callable(value) and not type(value).__module__.startswith("symdyn."))


F = TypeVar("F", bound=Callable[..., Any])

FIELDS = "fields"
"""What a function calls the keywords that are fields of a noun, `**fields`."""

_NOUNS: dict[Callable[..., object], tuple[type, ...]] = {}
"""The nouns of such functions."""


def _keyword(name: str, value: object = None) -> str:
    """Return an argument as a call in Python has it."""
    return name if value is None else f"{name}={_literal(value)}"


def _literal(value: object) -> str:
    """Return a value as Python reads it, whether a number is one or the text of one."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f'"{name}": {_literal(one)}' for name, one in value.items()) + "}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_literal, value))}]"
    if isinstance(value, float):
        return f"{value:g}"
    words = isinstance(value, str) and not value.removeprefix("-").replace(".", "", 1).isdigit()
    return f'"{value}"' if words else str(value)


_NAMING: ContextVar[Callable[..., str]] = ContextVar("naming", default=_keyword)


def argument(name: str, value: object = None, python: str = "") -> str:
    """Return what a message calls an argument: that of a call in Python, or what the command line makes of it.

    >>> argument("every"), argument("every", 0.1), argument("ignore_limits", True)
    ('every', 'every=0.1', 'ignore_limits=True')

    With a `value` that would work; `python` is what Python has in place of an argument.
    """
    found = _NAMING.get()
    return python if python and found is _keyword else found(name, value)


@contextmanager
def naming(words: Callable[..., str]) -> Iterator[None]:
    """Let a function name arguments, and values of them, in all messages that are made inside."""
    before = _NAMING.set(words)
    try:
        yield
    finally:
        _NAMING.reset(before)


@dataclass(frozen=True)
class ArgumentKind:
    """What an annotation stands for, with words for what to give, and for several of it."""

    words: tuple[str, str]
    takes: Callable[[Any], bool]


def _single(value: Any) -> bool:
    if isinstance(value, str | bytes) or getattr(value, "ndim", 0) != 0:
        return False
    hidden = getattr(value, "mask", False)  # of NumPy's masked arrays; others have a method of this name
    return callable(hidden) or not hidden


def _number(value: Any) -> bool:
    if not _single(value) or isinstance(value, bool) or not hasattr(type(value), "__float__"):
        return False
    if getattr(getattr(value, "dtype", None), "kind", "f") not in "fiu":  # a type of NumPy's that is no real number
        return False
    try:
        return isinstance(float(value), float)
    except (TypeError, ValueError, OverflowError):  # a symbol of SymPy, or more than a double holds
        return False


def _whole(value: Any) -> bool:
    if not _single(value) or isinstance(value, bool):
        return False
    try:
        return isinstance(index(value), int)
    except TypeError:  # an array has the method, whatever it holds
        return False


def _flag(value: Any) -> bool:
    try:
        return _single(value) and hasattr(type(value), "__bool__") and value in (0, 1)
    except (ArithmeticError, TypeError):  # a decimal that signals, a record
        return False


def _named(value: Any) -> bool:
    """Tell whether something holds values by name; a class has the methods of its objects."""
    if isinstance(value, type) or not (hasattr(value, "items") and hasattr(value, "keys")):
        return False
    return all(isinstance(one, str) for one in value.keys())  # noqa: SIM118  a series of pandas yields its values


def _path(value: Any) -> bool:
    return hasattr(type(value), "__fspath__") and isinstance(os.fspath(value), str)


KINDS = {
    "float": ArgumentKind(("a number", "numbers"), _number),
    "int": ArgumentKind(("a whole number", "whole numbers"), _whole),
    "bool": ArgumentKind(("True or False", "True or False"), _flag),
    "str": ArgumentKind(("text", "texts"), lambda value: isinstance(value, str)),
    "SympyExpression": ArgumentKind(("a SymPy expression", "SymPy expressions"), is_sympy),
    "None": ArgumentKind(("None", "None"), lambda value: value is None),
    "Callable": ArgumentKind(("a function", "functions"), is_function),
    "Mapping": ArgumentKind(("values by name, as in {'NAME': 0.3}", "mappings"), _named),
    "Array": ArgumentKind(("an array", "arrays"), lambda value: hasattr(value, "__array__")),
    **dict.fromkeys(("PathLike", "Path"), ArgumentKind(("a path", "paths"), _path)),
}
"""What stands by itself; a series of pandas has items, too."""


def _several(inside: Sequence[ast.expr], known: Mapping[str, object]) -> ArgumentKind:
    """Return a list of what brackets hold; what can be walked but once is walked by the function."""
    one = _kind(inside[0], known) if inside else None

    def takes(value: Any) -> bool:
        whole = isinstance(value, bytes | bytearray | Mapping | type) or getattr(value, "ndim", 1) == 0
        if whole or not isinstance(value, Iterable):
            return False
        entries: Iterable[Any] = value if isinstance(value, Sequence | Set) else ()
        if hasattr(value, "strides") and hasattr(value, "__getitem__"):
            kind = getattr(getattr(value, "dtype", None), "kind", "")
            entries = value if kind == "O" else value[:1]  # entries of all but objects are of one kind
        return one is None or all(map(one.takes, entries))

    return ArgumentKind((f"a list of {one.words[1]}" if one else "a list", "lists"), takes)


def _one_each(inside: Sequence[ast.expr], known: Mapping[str, object]) -> ArgumentKind:
    """Return so many values, each of its own kind."""
    kinds = [_kind(one, known) for one in inside]

    def takes(value: Any) -> bool:
        # an array has all the methods
        alone = isinstance(value, str | bytes | Mapping) or getattr(value, "ndim", 1) == 0
        walks = not alone and isinstance(value, Sized) and isinstance(value, Iterable) and len(value) == len(kinds)
        return walks and all(k is None or k.takes(x) for k, x in zip(kinds, value, strict=True))

    return ArgumentKind((f"{len(kinds)} values", "tuples"), takes)


def _function(inside: Sequence[ast.expr], known: Mapping[str, object]) -> ArgumentKind:
    """Return a function of so many arguments."""
    if not isinstance(inside[0], ast.List):
        return KINDS["Callable"]
    many = len(inside[0].elts)
    words = f"a function of {many} argument{'s' * (many != 1)}"

    def takes(value: Any) -> bool:
        try:
            return is_function(value) and inspect.signature(value).bind(*range(many)) is not None
        except (TypeError, ValueError) as fault:  # what is written in C may have no signature
            return isinstance(fault, ValueError)

    return ArgumentKind((words, words.replace("a function", "functions")), takes)


def _one_of(inside: Sequence[ast.expr], known: Mapping[str, object]) -> ArgumentKind:
    """Return one of some words."""
    words = tuple(ast.literal_eval(one) for one in inside)
    told = " or ".join(repr(one) for one in words)
    return ArgumentKind((told, told), lambda value: isinstance(value, str) and value in words)


OF_KINDS = {
    "Literal": _one_of,
    **dict.fromkeys(("Sequence", "Collection", "Iterable"), _several),
    "tuple": _one_each,
    "Mapping": lambda inside, known: KINDS["Mapping"],
    "Callable": _function,
}
"""What is made of the kinds in brackets behind it."""


def with_fields(*nouns: type) -> Callable[[F], F]:
    """Let a function that takes the fields of some dataclasses by `**fields` show them, and have them checked.

    Its signature has them with the defaults of the nouns, and its docstring with their words, in place of the line of
    `**fields`. A parameter or a line of its own goes first.
    """

    def shown(function: F) -> F:
        own, fields, lines = inspect.signature(function), list[inspect.Parameter](), ""
        said = inspect.cleandoc(function.__doc__ or "")
        for noun in nouns:
            for name, one in inspect.signature(noun).parameters.items():
                if name not in own.parameters:
                    kind = re.sub(r"^InitVar\[(.*)\]$", r"\1", one.annotation)
                    fields.append(one.replace(kind=one.KEYWORD_ONLY, annotation=kind))
                    told = f"{inspect.getdoc(noun)}\n" if f"\n    {name}: " not in said else ""
                    lines += "".join(re.findall(rf"(?m)^    {name}: .*\n(?:     .*\n)*", told)[:1])
        called = suggesting(function)
        _NOUNS[function] = _NOUNS[called] = nouns
        first = [one for one in own.parameters.values() if one.kind is one.POSITIONAL_OR_KEYWORD]
        last = [one for one in own.parameters.values() if one.kind is one.KEYWORD_ONLY]
        for each in (function, called):
            each.__signature__ = own.replace(parameters=[*first, *fields, *last])  # type: ignore[attr-defined]
            each.__doc__ = re.sub(rf"(?m)^    \*\*{FIELDS}: .*\n", lambda _: lines, said)
        return called

    return shown


def suggesting(function: F) -> F:
    """Let a function, or a class, say how it is called where a call does not fit it, and which keyword was meant.

    >>> @suggesting
    ... def fly(up: float) -> None: ...
    >>> fly(upp=3)
    Traceback (most recent call last):
    symdyn.errors.ArgumentError: fly() got an unexpected keyword argument 'upp'; did you mean up? (there are up)
    """
    if isinstance(function, type):
        function.__init__ = suggesting(function.__init__)  # type: ignore[misc]
        return function

    @wraps(function)
    def called(*values: Any, **keywords: Any) -> Any:
        if not function.__module__.endswith("sympy_equations"):  # which looks at assumptions, too
            values, keywords = tuple(map(with_names, values)), {name: with_names(one) for name, one in keywords.items()}
        try:
            return function(*values, **keywords)
        except TypeError as error:
            if isinstance(error, ArgumentError) or (at := error.__traceback__) is None or at.tb_next is not None:
                raise  # from inside
            told = re.sub(r"\.__(init|call)__", "", str(error)).rpartition(".")[2]
        _refuse_unknown(function, keywords, values[0] if values else None)
        takes = [one for one in inspect.signature(function).parameters.values() if one.name not in ("self", "cls")]
        loose = {one.name: _read(function).get(one.name) for one in takes if one.kind is one.KEYWORD_ONLY}
        keys = {one.name: [f"{name}=" for name in _keys(function, one)] for one in takes}
        given = ", ".join(listed(keys[name], 4) if keys[name] else name + "=" * (name in loose) for name in keys)
        beyond = values[len(inspect.signature(function).parameters) - len(loose) :][:1]
        beyond += tuple(one[-1] for one in beyond if isinstance(one, tuple | list) and [*map(type, one)][-1:] != [str])
        likely = ((k, x) for x in beyond for k, a in loose.items() if a and a.takes(x))
        named = [(k, x) for k, x in likely if not isinstance(x, str | list) or (k in HELD) == ("=" in str(x))]
        own = {k: names_of(values[0], HELD.get(k, k)) for k, _ in named}
        named.sort(key=lambda one: {*re.findall(r"\w+", str(one[1]))}.isdisjoint(own[one[0]]))
        fits = ["; the scene comes first" for one in beyond if hasattr(one, "coordinates")]
        fits += [f"; it goes by name, {k}={quoted(x)}" for k, x in named]
        raise ArgumentError(f"{told}{''.join(fits[:1])}; call it as {_called(function)}({given})")

    return cast(F, called)


def _keys(function: Callable[..., object], one: inspect.Parameter) -> Sequence[str]:
    """Return the keywords of `**keys: Unpack[Keys]`; none of another parameter."""
    noun = vars(sys.modules[function.__module__]).get(str(one.annotation).removeprefix("Unpack[").removesuffix("]"))
    return tuple(noun.__annotations__) if one.kind is one.VAR_KEYWORD and noun else ()


def _called(function: Callable[..., object]) -> str:
    """Return the name by which a function is called; a class by its own."""
    return re.sub(r"\.__(init|call)__$", "", function.__qualname__).rpartition(".")[2]


def _refuse_unknown(function: Callable[..., object], keywords: Mapping[str, object], noun: object) -> None:
    """Raise ArgumentError for a keyword that a function, called with a scene or another noun, does not have."""
    takes = inspect.signature(function).parameters.values() if keywords else ()
    known = [name for one in takes if one.name not in ("self", "cls") for name in _keys(function, one) or [one.name]]
    for name in (one for one in keywords if one not in known):
        needed, told = hint("keywords", name, (*known, name, _called(function))) or ("", "")
        fits = needed and not {name[:-1], f"{name}es"} & {*known}
        told = told.replace("$", name).replace("{}", repr(keywords[name])) if fits else choice(name, known)
        if {"values", "start"} <= {*known} and told.startswith("there"):
            told = f"{('values', 'over')['over' in known]}={{'NAME': ...}} gives a parameter; {told}"
        told = with_own_names(told, noun)
        for one in (one for one in reversed(known) if name in names_of(noun, HELD.get(one, ""))):
            told = f"it is {one}={{{name!r}: {keywords[name]!r}}}"
        raise ArgumentError(f"{_called(function)}() got an unexpected keyword argument {name!r}; {told}")


def check_arguments(
    function: Callable[..., object], arguments: Mapping[str, Any], error: type[SymdynError] = ArgumentError
) -> Mapping[str, Any]:
    """Raise an error that tells every argument of a kind that a function does not take, one line each.

    Returned are the arguments, `**fields` among the others; what is no argument of the function is not looked at.

    Raises:
        ArgumentError: a keyword among its `**fields` that is none.
    """
    fields: Mapping[str, Any] = arguments[FIELDS] if function in _NOUNS else {}
    _refuse_unknown(function, fields, arguments.get("scene"))
    lines, given = [], {**arguments, **fields}
    for name, kind in _read(function).items():
        if name in given and not kind.takes(value := given[name]):
            measured = isinstance(value, str) and re.fullmatch("-?[0-9.]+ *[A-Za-z][A-Za-z0-9 */^]*", value)
            unit = ", in SI" if measured and "number" in kind.words[0] else ""
            lines.append(f"{name} = {quoted(value)}: give {kind.words[0]}{unit}{_way_out(function, name, given)}")
    if lines:
        raise error(lines if hasattr(error(""), "faults") else "\n".join(lines))
    return given


def _way_out(function: Callable[..., object], name: str, given: Mapping[str, Any]) -> str:
    """Return what does what an argument was given for, or the names that it takes; "" where neither is known."""
    if hasattr(given[name], "coordinates") and "scene" in given:
        return "; the scene comes first"
    (needed, told), noun = hint("arguments", name) or ("", ""), given.get("self", given.get("scene"))
    if needed in inspect.signature(function).parameters:
        return f"; {with_own_names(told, noun).replace('$', quoted(given[name]))}"
    names, value = names_of(noun, HELD.get(name, f"{name}s")), given[name]
    whole = KINDS["bool"].takes(value) or hasattr(value, "keys") or (isinstance(value, str) and "=" in value)
    others = [k for k, one in _read(function).items() if given.get(k) is None and one.takes(value) and not whole]
    told = "".join([f", or {k}={quoted(given[name])}" for k in others[:1]])
    return f"{told}; names are {listed(names)}" * bool(names)


def checked(error: type[SymdynError], read: Callable[[dict[str, Any]], dict[str, Any]] = dict) -> Callable[[F], F]:
    """Let a function or method read and check its arguments, as of `check_arguments`, and tell of keywords it lacks."""

    def around(function: F) -> F:
        @wraps(function)
        def call(*values: Any, **keywords: Any) -> Any:
            try:
                given = inspect.signature(function).bind(*values, **keywords)
            except TypeError:
                return suggesting(function)(*values, **keywords)
            given.arguments = read({name: with_names(one) for name, one in given.arguments.items()})
            check_arguments(function, given.arguments, error)
            return function(*given.args, **given.kwargs)

        return call  # type: ignore[return-value]

    return around


def walked(
    function: Callable[..., object], arguments: Mapping[str, Any], *names: str, error: type[SymdynError] = ArgumentError
) -> tuple[tuple[Any, ...], ...]:
    """Return lists among the arguments as tuples, after `check_arguments`, which sees what generators held too."""
    check_arguments(function, arguments, error)
    told = {name: tuple(arguments[name]) for name in names}
    check_arguments(function, {**arguments, **told}, error)
    return tuple(told.values())


def native(kind: Callable[[Any], object], *values: object) -> tuple[Any, ...]:
    """Return numbers, or truth values, that a function takes, of any library, as Python's own, and None as None."""
    return tuple(None if one is None else kind(one) for one in values)


@cache
def _read(function: Callable[..., object]) -> dict[str, ArgumentKind]:
    """Return what every argument of a function may be, of those whose kind is known."""
    bare: Any = inspect.unwrap(function)
    known = ChainMap(*(vars(sys.modules[one.__module__]) for one in (bare, *_NOUNS.get(bare, ())[::-1])))
    said = inspect.signature(bare).parameters.values()
    written = {one.name: one for one in said if isinstance(one.annotation, str) and one.kind is not one.VAR_KEYWORD}
    nodes = {name: ast.parse(one.annotation, mode="eval").body for name, one in written.items()}  # all but self
    several = {name for name, one in written.items() if one.kind is inspect.Parameter.VAR_POSITIONAL}
    kinds = {name: _several([x], known) if name in several else _kind(x, known) for name, x in nodes.items()}
    return {name: kind for name, kind in kinds.items() if kind is not None}


def _kind(node: ast.expr, known: Mapping[str, object]) -> ArgumentKind | None:
    """Return the kind of an annotation, None where a part of it is not known."""
    if isinstance(node, ast.BinOp):
        return _either(_kind(node.left, known), _kind(node.right, known))
    if isinstance(node, ast.Subscript):
        name = _last(node.value)
        entries = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if name == "tuple" and ast.unparse(entries[-1]) == "...":  # of any length
            name, entries = "Sequence", entries[:-1]
        return OF_KINDS[name](entries, known) if name in OF_KINDS else KINDS.get(name)
    named = known.get(name := _last(node))
    if name not in KINDS and (isinstance(named, UnionType) or get_origin(named) in (tuple, Callable)):
        return _kind(ast.parse(str(named), mode="eval").body, known)  # a name for such as `str | Path`
    if name not in KINDS and isinstance(named, type) and named is not Any and not getattr(named, "_is_protocol", False):
        return ArgumentKind((f"a {named.__name__}", named.__name__), lambda value: isinstance(value, named))
    return KINDS.get(name)


def _last(node: ast.expr) -> str:
    """Return a name without the module that it is from."""
    return ast.unparse(node).rpartition(".")[2]


def _either(left: ArgumentKind | None, right: ArgumentKind | None) -> ArgumentKind | None:
    """Return what one of two kinds takes."""
    if left is None or right is None:
        return None
    words = tuple(" or ".join(both) for both in zip(left.words, right.words, strict=True))
    return ArgumentKind((words[0], words[1]), lambda value: left.takes(value) or right.takes(value))
