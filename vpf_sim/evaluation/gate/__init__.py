"""Whether a run keeps the rules, and is no worse than a run before."""
