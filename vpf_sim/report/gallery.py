"""The gallery's page: one HTML file that needs nothing but the pictures and videos beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

from jinja2 import Environment, StrictUndefined


@dataclass(frozen=True, slots=True)
class Picture:
    caption: str
    file: str  # relative to the page


@dataclass(frozen=True, slots=True)
class Entry:
    """One weather."""

    name: str
    aliases: tuple[str, ...]
    meaning: str  # in a line of words
    factors: tuple[tuple[str, str, str], ...]  # name, value, meaning
    pictures: tuple[Picture, ...]  # one a pose, in the same order in every entry
    video: str


def page(entries: Sequence[Entry]) -> str:
    """The page as HTML, a row a weather and a column a pose."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("vpf_sim.report").joinpath("gallery.html.jinja").read_text("utf-8")
    return environment.from_string(template).render(entries=entries)
