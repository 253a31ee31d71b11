"""What joints transmit: D'Alembert's equilibrium of every body, eq. (5.1)-(5.20)."""
