"""A scene's file, watched: a page in the browser that shows what stands in it, while it is written."""

from symdyn.watch.watching import Watched, watch

__all__ = ["Watched", "watch"]
