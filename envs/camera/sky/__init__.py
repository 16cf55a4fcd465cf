"""Sky, clouds and hills."""
