"""Speed limits: by bends and obstacles, and by the clear distance."""
