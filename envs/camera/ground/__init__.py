"""The ground: road and verge, painted into rasters that follow the camera."""
