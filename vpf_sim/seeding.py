"""Random streams: every random thing draws from its own, so that adding one never changes another."""

from hashlib import sha256

import numpy as np


def stream(seed: int, name: str) -> np.random.Generator:
    """The generator of the thing called `name` in the episode of `seed`: the same in every process and host."""
    digest = sha256(f"{seed}/{name}".encode()).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(digest[:16], "little")))
