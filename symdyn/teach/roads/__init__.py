"""Roads from a scene to its equations, each as a lesson, and the door to them."""
