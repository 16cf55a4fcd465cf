"""Optical flow, the camera's own motion and pitch, and depth from motion."""
