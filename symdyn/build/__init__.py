"""Builds: the only room that runs a compiler."""

from symdyn.build.door import build, lambdify, run_python
from symdyn.build.module import CFunction, Module

__all__ = ["CFunction", "Module", "build", "lambdify", "run_python"]
