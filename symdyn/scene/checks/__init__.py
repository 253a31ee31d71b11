"""Checks of a scene, one noun a file."""
