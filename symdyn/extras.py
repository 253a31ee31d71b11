"""Packages that a user may have beside symdyn, each named by the job that it is for.

`pyproject.toml` says which versions; a test holds both lists together.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from symdyn.frozen import dataclass


@dataclass(frozen=True)
class Extra:
    """One job that takes packages of its own."""

    modules: tuple[str, ...]  # what is imported, by which one sees whether it is there
    without: str  # what a user does without where it is missing, one line

    @property
    def there(self) -> bool:
        """Whether the first of its packages is installed, without which there is nothing of it."""
        return find_spec(self.modules[0]) is not None


GRAMMARS = ("c", "cpp", "cuda", "javascript", "python", "rust", "matlab", "julia")
"""Languages whose text is read by grammars of others."""

EXTRAS = {
    "plot": Extra(
        ("matplotlib", "imageio_ffmpeg", "pygltflib", "trimesh", "collada"),
        "no plots, no PNG or PDF pictures, no GIF, MP4 or glTF",
    ),
    "simulate": Extra(("heyoka", "sksundae"), "SciPy integrates: no Taylor series, no SUNDIALS for stiff systems"),
    "robots": Extra(("mujoco",), "MJCF is not read"),
    "teach": Extra(("latex2mathml",), "no lessons in HTML"),
    "control": Extra(("control",), "no hand-over to python-control"),
    "optimal": Extra(("casadi",), "collocation is not solved here, only handed to a solver"),
    "identify": Extra(("clarabel",), "identified inertias may be physically inconsistent"),
    "ik": Extra(("eaik",), "paths begin next to the start: no closed forms of inverse kinematics, no --branch"),
    "sweep": Extra(("dask", "distributed", "zarr"), "sweeps run on this machine alone, and are not kept on disk"),
    "shell": Extra(("shtab",), "no completion of verbs and options in a shell"),
    "prove": Extra(
        ("tree_sitter", *(f"tree_sitter_{name}" for name in GRAMMARS)),
        "verify measures generated files and does not prove their text",
    ),
    "jax": Extra(("jax",), "no functions for JAX; NumPy's and those in C are there"),
    "torch": Extra(("torch",), "no functions for PyTorch; NumPy's and those in C are there"),
    "zig": Extra(("ziglang",), "no compiler where the system has none: NumPy modules instead"),
}
"""By name, in the order in which `symdyn doctor` shows them."""


def install(extra: str) -> str:
    """Return the command that installs an extra, quoted so that every shell takes it.

    >>> install("plot")
    'pip install "symdyn[plot]"'
    """
    if extra not in EXTRAS:
        raise KeyError(f"no extra {extra}; there are {', '.join(EXTRAS)}")
    return f'pip install "symdyn[{extra}]"'


def package(name: str, error: type[Exception], instead: str = ".table() and .to_csv()") -> Any:
    """Return a package of its own that `to_` and its name hands data to; the error where it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        cure = f"pip install {name}, or take {instead}"
        raise error(f"to_{name}() needs {name}, which is not installed; {cure}") from None
