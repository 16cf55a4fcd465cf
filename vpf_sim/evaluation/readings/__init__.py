"""The readings of the paper: the space of what it leaves open (`space`), and a search over it (`search`)."""
