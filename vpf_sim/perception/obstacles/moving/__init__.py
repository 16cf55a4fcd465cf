"""Moving obstacles: detected, tracked, and weighed point by point against what stands."""
