"""`vpf-sim profile`."""


def profile() -> None:
    """Being wired."""
