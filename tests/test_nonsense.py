"""Every door of the reference says in words which argument it does not take, and what it takes."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from reference import CONSTRUCTED, catalogue, members, object_of

from symdyn.errors import SymdynError

NAMES = [name for names in catalogue().values() for name in names]


def called(name: str) -> dict[str, Callable[..., object]]:
    """Return what a user may call of a name: itself, or the methods of what functions return, without an object."""
    one: Any = object_of(name)
    if not inspect.isclass(one):
        return {name: one}
    own = {**members(one), "__call__": vars(one).get("__call__")}
    found = {key: inspect.getattr_static(one, key) for key, each in own.items() if each is not None}
    bound = {key: getattr(one, key) for key, each in found.items() if isinstance(each, classmethod | staticmethod)}
    methods = {key: partial(each, None) for key, each in found.items() if inspect.isfunction(each)}
    loose = {key for key, each in methods.items() if "**" in str(inspect.signature(each))}
    both = {key: each for key, each in (methods | bound).items() if key not in loose}
    return {f"{name}.{key}": each for key, each in both.items()} | ({name: one} if one.__name__ in CONSTRUCTED else {})


CALLED = {key: one for name in NAMES for key, one in called(name).items()}


@pytest.mark.parametrize("name", CALLED)
def test_an_argument_that_is_none_is_told_with_what_is_taken(name: str) -> None:
    with pytest.raises(SymdynError, match=r"(?i)nonsense") as told:
        CALLED[name](nonsense=1)
    assert re.search(r"; (did you mean |there are |it |call it as |give |.* takes )", str(told.value)), str(told.value)
