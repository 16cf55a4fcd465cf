"""Everything that rises from the ground: objects, road furniture, trees."""
