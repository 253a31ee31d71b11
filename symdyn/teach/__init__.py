"""Lessons: the derivation of a scene as one document, and what renders it."""
