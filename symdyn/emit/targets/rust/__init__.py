"""The Rust target: `module.py` is its row, `fused.py` writes expressions, `two_over_pi.py` digits for huge angles."""

from symdyn.emit.targets.rust.module import RUST

__all__ = ["RUST"]
