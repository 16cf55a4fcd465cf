"""The gate: whether a run satisfies rules, and is no worse than a baseline."""
