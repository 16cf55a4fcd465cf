"""Statistics of rendered frames on scripted drives: shimmer, and comparison with recorded drives."""
