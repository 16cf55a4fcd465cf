"""Speed limits: by bends and obstacles, by what can be seen, by tentative obstacles, and creep."""
