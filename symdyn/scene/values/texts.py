"""What parameters, inputs and outputs of a scene are, in one language."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from symdyn.scene.values.model import Input, Parameter, Scene, Signal

_Described = TypeVar("_Described", Parameter, Input, Signal)


def in_language(scene: Scene, code: str) -> Scene:
    """Return the scene with every description in a language, such as "sk", where the scene has it."""

    def said(one: _Described) -> _Described:
        return replace(one, text=dict(one.texts).get(code, one.text))

    return replace(
        scene,
        parameters=tuple(map(said, scene.parameters)),
        inputs=tuple(map(said, scene.inputs)),
        outputs=tuple(map(said, scene.outputs)),
    )
