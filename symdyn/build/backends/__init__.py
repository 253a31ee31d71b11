"""Functions of a scene for NumPy, JAX and PyTorch: the door and the table of backends are in `door.py`."""
