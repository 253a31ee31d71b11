"""Targets: one file each, or a folder; the table of them and the door are in `door.py`."""
