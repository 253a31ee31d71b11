"""D'Alembert's formulation (5.1)-(5.20): bodies cut free, loops, equilibrium, all reactions."""
