"""Rigorous enclosures on cells of frequency and parameters, for what is not a polynomial question."""
