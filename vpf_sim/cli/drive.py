"""`vpf-sim drive`."""


def drive() -> None:
    """Being wired."""
