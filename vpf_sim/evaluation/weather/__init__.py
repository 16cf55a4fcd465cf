"""Physical meaning of a weather, its effect on tracking, and water on the windscreen."""
