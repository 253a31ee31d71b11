"""Builds: the only room that runs a compiler."""

from symdyn.build.c import build
from symdyn.build.door import lambdify
from symdyn.build.module import CFunction, Module
from symdyn.build.python import run_python
from symdyn.build.runners import RUNNERS, Runner

__all__ = ["RUNNERS", "CFunction", "Module", "Runner", "build", "lambdify", "run_python"]
