"""What stands up from the ground: bodies, furniture of the road, trees."""
