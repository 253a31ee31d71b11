"""From measured motion to parameters: base parameters with their standard errors, and a scene that has them."""
