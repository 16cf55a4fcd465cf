"""The neutral controller: neither throttle nor steering; a minimal example."""

from vpf_sim.types import Command


class Neutral:
    def reset(self) -> None:
        """No state."""

    def command(self) -> Command:
        """Coast straight ahead."""
        return Command(0.0, 0.0)
