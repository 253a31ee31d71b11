"""D'Alembert's method (5.1)-(5.20): bodies cut free, loops, equilibrium, all reactions."""
