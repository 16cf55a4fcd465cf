"""Commands of the docs' shell blocks."""


def shell_lines(block: str) -> list[str]:
    """The commands of a block; a backslash at the end of a line joins it with the next."""
    return block.replace("\\\n", "").splitlines()
