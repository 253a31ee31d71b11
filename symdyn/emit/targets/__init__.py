"""Targets: a file each, or one for two of a kind, C a folder; the table of them and `emit` are in `emit_program.py`."""
