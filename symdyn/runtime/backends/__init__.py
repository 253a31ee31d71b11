"""Functions of a scene for NumPy, JAX and PyTorch: `load` and the table of backends are in `load_functions.py`."""
