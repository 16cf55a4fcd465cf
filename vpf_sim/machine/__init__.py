"""Checks of this machine's installation, determinism and speed."""
