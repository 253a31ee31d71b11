"""Ways from a scene to its equations, each as a lesson."""
