"""Open-loop evaluation of perception: stored drives are re-rendered and scored against ground truth."""
