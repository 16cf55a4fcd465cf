"""`vpf-sim sweep`."""


def sweep() -> None:
    """Being wired."""
