"""Low obstacles, by where the road does not move in the picture as a plane does."""
