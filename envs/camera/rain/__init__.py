"""Water outside: falling, on the road, thrown up."""
