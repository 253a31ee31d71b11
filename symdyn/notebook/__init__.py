"""What a notebook shows of every noun that a door returns."""

from symdyn.notebook.rows import bundle

__all__ = ["bundle"]
