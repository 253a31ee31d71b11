"""Closed mechanisms: what loops demand, where they close, what they leave free, and the equations of what is left."""
