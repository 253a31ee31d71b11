"""Launchers: what hosts call of kernels, an `extern "C"` function a kernel, behind the kernels' own text."""

from __future__ import annotations

from symdyn.emit.code.identifiers import stem
from symdyn.emit.code.real import find_real
from symdyn.emit.code.target import Sources
from symdyn.emit.render import render
from symdyn.emit.targets.gpu.kernels import budgets

END = "_launch"
"""How the name of a launcher ends, behind the name of its kernel."""


def launchers(sources: Sources) -> dict[str, str]:
    """Return kernels for CUDA with a launcher each as one file, by its name.

    Args:
        sources: of target "gpu".
    """
    name = stem(sources.program.scene.name)
    listed = [
        {
            "name": f"{name}_{spelled}",
            "arguments": len(routine.function.arguments),
            "block": room.block,
            "parts": len(room.plans),
        }
        for spelled, routine, room in zip(
            sources.functions, sources.program.routines, budgets(sources.program, find_real(sources.real)), strict=True
        )
    ]
    values = {"real": sources.real, "kernels": listed, "end": END}
    text = f"{sources.texts[f'{name}.cu']}\n{render('gpu/launchers.cu.jinja', values)}"
    return {f"{name}.cu": text}
