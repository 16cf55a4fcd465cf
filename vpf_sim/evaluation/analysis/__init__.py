"""Statistics, comparisons and tables of a run's records, and their rescoring."""
