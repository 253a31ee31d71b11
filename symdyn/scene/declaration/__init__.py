"""From tables as they are written to a scene that has passed its checks."""
