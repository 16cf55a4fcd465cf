"""Lamps in the dark: the car's own beam, street lamps, what they light, and lamps that shine into the camera."""
