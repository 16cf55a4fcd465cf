"""`vpf-sim benchmark`."""


def benchmark() -> None:
    """Being wired."""
