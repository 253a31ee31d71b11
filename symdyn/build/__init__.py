"""Builds: the only room that runs a compiler."""

from symdyn.build.c_module import CFunction, Module, build
from symdyn.build.loaded import lambdify
from symdyn.build.mockup_binary import with_binaries
from symdyn.build.runners import RUNNERS, Runner, run_python

__all__ = ["RUNNERS", "CFunction", "Module", "Runner", "build", "lambdify", "run_python", "with_binaries"]
