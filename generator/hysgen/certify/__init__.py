"""Guarantees for a model: contraction, gain, stability of the inverse, with rigorous enclosures over its range."""
