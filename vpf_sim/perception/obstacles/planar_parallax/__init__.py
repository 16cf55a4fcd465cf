"""Low obstacles, by where the image of the road does not move as a plane does."""
