"""Water on the windscreen, and the wiper."""
