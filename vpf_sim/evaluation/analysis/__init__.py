"""What the records of a run say: intervals, paired differences, tables; and the records scored once more."""
