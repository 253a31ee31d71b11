"""The interactive page: sliders move the mechanism, every coefficient, every force and the energies follow.

Trees and closed mechanisms, quaternions too. What the page computes is emitted from the graph, as a program that
`live` chooses; the script of the page draws, closes loops by Newton's method and integrates the motion.
"""

from symdyn.teach.interactive.live import Live, absence, live
from symdyn.teach.interactive.page import Interactive, interactive, interactive_page

__all__ = ["Interactive", "Live", "absence", "interactive", "interactive_page", "live"]
