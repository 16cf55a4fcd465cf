"""Readings of the paper: the space of its unspecified quantities, and a search over it."""
