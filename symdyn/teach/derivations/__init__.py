"""Formulations from a scene to its equations, each as a lesson, and the entry point to them."""
