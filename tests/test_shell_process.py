"""In the shell's own process methods of dataclasses are compiled when they are first called, and are what they were."""

from __future__ import annotations

import subprocess
import sys

import pytest

LATE = """
from symdyn import shell
shell.take()
shell.postpone()
import inspect
from dataclasses import FrozenInstanceError, dataclass, field, replace

@dataclass(frozen=True, order=True)
class Base:
    x: int = 1
    names: list = field(default_factory=list, compare=False)

@dataclass(frozen=True, slots=True)
class Derived(Base):
    z: int = 3

before = Base.__eq__
print(inspect.signature(Derived))
print(Base(), Derived(2, z=4), Base() == Base(1), Base(1) < Base(2), len({Base(2), Base(2)}), replace(Base(), x=5))
print(Base.__eq__ is before, Base.__eq__.__qualname__)
for one in (Base(), Derived()):
    try:
        one.x = 3
    except FrozenInstanceError as fault:
        print(fault)
try:
    Base(1, 2, 3)
except TypeError as fault:
    print(fault)
"""

TOLD = """\
(x: int = 1, names: list = <factory>, z: int = 3) -> None
Base(x=1, names=[]) Derived(x=2, names=[], z=4) True True 1 Base(x=5, names=[])
False Base.__eq__
cannot assign to field 'x'
cannot assign to field 'x'
Base.__init__() takes from 1 to 3 positional arguments but 4 were given
"""


@pytest.mark.runs
@pytest.mark.skipif(sys.version_info >= (3, 13), reason="all methods of a class are compiled at once there")
def test_methods_that_are_compiled_late_are_the_same() -> None:
    done = subprocess.run([sys.executable, "-c", LATE], capture_output=True, text=True, check=True)

    assert done.stdout == TOLD
