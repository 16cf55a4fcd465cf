"""One episode that is asked for: the names of what makes it, and the id that they make."""

import re
from hashlib import sha256
from os import fsencode
from typing import NamedTuple


class Job(NamedTuple):
    """A scenario and a weather by name or file, a driver by name, and a seed."""

    scenario: str
    weather: str
    driver: str
    seed: int

    @property
    def id(self) -> str:
        """Unique and fit for a file's name: "town04.clear.vpf.1003"."""
        return ".".join([_slug(self.scenario), _slug(self.weather), _slug(self.driver), str(self.seed)])


def _slug(name: str) -> str:
    """A plain name as it is; of a path the last part, told apart from others by a hash."""
    if re.fullmatch(r"[\w@-]+", name):
        return name
    last = re.split(r"[/\\:]", name.removesuffix(".toml"))[-1]
    return f"{re.sub(r'[^A-Za-z0-9_-]', '_', last)}-{sha256(fsencode(name)).hexdigest()[:8]}"
