"""Builds: the only room that runs a compiler."""

from symdyn.build.compiled import lambdify
from symdyn.build.module import CFunction, Module
from symdyn.build.run_c import build
from symdyn.build.run_python import run_python
from symdyn.build.runners import RUNNERS, Runner

__all__ = ["RUNNERS", "CFunction", "Module", "Runner", "build", "lambdify", "run_python"]
