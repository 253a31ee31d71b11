"""What a scene is made of: exact quantities and formulas, names, and the nouns that hold them."""
