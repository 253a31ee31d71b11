"""Targets: one file each, or a folder; the table of them and `emit` are in `emit_program.py`."""
