"""Every weather at fixed poses, as a page, and what a weather means in physical units."""
