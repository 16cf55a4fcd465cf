"""Hands off: neither throttle nor steering. The least that a controller can be."""

from vpf_sim.types import Command


class Neutral:
    def reset(self) -> None:
        """Nothing to forget."""

    def command(self) -> Command:
        """Coast straight on."""
        return Command(0.0, 0.0)
