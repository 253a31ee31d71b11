"""Along the tree, body by body: Newton and Euler's recursions, in frames and with inertias chosen for them."""
