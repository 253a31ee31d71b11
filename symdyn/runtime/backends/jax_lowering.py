"""What XLA's program calls of a word, by platform: the C on the CPU, kernels on a card (`jax_card.py`).

Code is made when a program is lowered for a platform, for that platform alone.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.interpreters import mlir

from symdyn.errors import BuildError
from symdyn.runtime.backends.jax_card import CARDS, over_columns
from symdyn.runtime.backends.words import Word

REALS = {"float64": "double", "float32": "float"}


def lower_by_platform(primitive: Any, rule: Callable[..., Any]) -> None:
    """Let XLA's programs do what `rule` returns for a platform: of its name, JAX's context and operands."""
    mlir.register_lowering(primitive, _nowhere_else)
    for platform in ("cpu", *CARDS):
        mlir.register_lowering(primitive, partial(rule, platform), platform=platform)


def lowered(platform: str, context: Any, *operands: Any, word: Word) -> Any:
    """Return the call of a word in XLA's program; without entries or states there is nothing to call."""
    (result,) = context.avals_out
    if 0 in result.shape:
        return _as_written(lambda *_: jnp.zeros(result.shape, result.dtype), context, *operands)
    handler = _handler(platform, word, result)
    if platform not in CARDS:
        return jax.ffi.ffi_lowering(handler)(context, *operands)
    leading = result.shape[: len(result.shape) - len(word.shape)]
    return _as_written(partial(over_columns, handler, platform, word, leading), context, *operands)


def times_lowered(
    plain: Callable[..., Any], platform: str, context: Any, *operands: Any, word: Word, left: bool
) -> Any:
    """Return the call of all of J times directions; `plain` where there is no code for that, as on a card."""
    (result,) = context.avals_out
    if platform in CARDS or 0 in result.shape:
        return _as_written(partial(plain, word=word, left=left), context, *operands)
    return jax.ffi.ffi_lowering(_handler(platform, word, result, "weighted" if left else "columns"))(context, *operands)


def _handler(platform: str, word: Word, result: Any, kind: str = "") -> str:
    """Return what XLA calls a word."""
    name, card = word.routine.function.name, CARDS.get(platform)
    made = word.code.ready(REALS[result.dtype.name], None if card is None else card.kernels)
    found: str | None = made.get((name, kind))
    if found is None:
        raise BuildError(f"{name} takes an argument without entries, which XLA cannot hand on")
    return found


def _as_written(function: Callable[..., Any], context: Any, *operands: Any) -> Any:
    """Return the program of a function of JAX's arrays."""
    return mlir.lower_fun(function, multiple_results=False)(context, *operands)


def _nowhere_else(context: Any, *operands: Any, word: Word, **_: Any) -> Any:
    """Refuse another platform."""
    others = ", ".join(context.module_context.platforms)
    raise BuildError(
        f"{word.routine.function.name} runs on the CPU and on CUDA, there is no kernel for {others}; "
        'put its arguments there by jax.device_put(x, jax.devices("cpu")[0])'
    )
