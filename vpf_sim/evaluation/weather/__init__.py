"""Physical meaning of a weather, and its effect on tracking."""
