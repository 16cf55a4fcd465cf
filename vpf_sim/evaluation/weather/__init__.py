"""What a weather means, and what it does to the plain perception."""
