"""Targets: one file each, C a folder; the table of them and `emit` are in `emit_program.py`."""
