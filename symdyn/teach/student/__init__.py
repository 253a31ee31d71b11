"""What a student hands in: formulas in LaTeX or plain text, read without evaluating anything."""
