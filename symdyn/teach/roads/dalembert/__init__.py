"""D'Alembert's road (5.1)-(5.20): bodies cut free, loops, equilibrium, all reactions."""
