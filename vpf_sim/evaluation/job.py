"""A planned episode and its id."""

import re
from typing import NamedTuple

from vpf_sim.files import file_name


class Job(NamedTuple):
    """A scenario and a weather by name or file, a driver by name, and a seed."""

    scenario: str
    weather: str
    driver: str
    seed: int

    @property
    def id(self) -> str:
        """Unique id, usable as a file name: "town04.clear.vpf.1003"."""
        return ".".join([_slug(self.scenario), _slug(self.weather), _slug(self.driver), str(self.seed)])


def _slug(name: str) -> str:
    """A plain name unchanged; of a path its last part with a hash."""
    return file_name(name, re.split(r"[/\\:]", name.removesuffix(".toml"))[-1])
