"""Speed limits: by bends and obstacles, by the clear distance, and by tentative obstacles."""
