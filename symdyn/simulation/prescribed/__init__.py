"""What a user prescribes over time: driving forces and motions, from formulas, named laws and tables of numbers."""
