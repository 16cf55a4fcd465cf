"""Obstacles on the road: `static_tracker` for standing ones; low ones and moving ones have packages of their own."""
