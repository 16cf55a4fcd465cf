"""The page of the moving pictures: what it shows, and its text."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from vpf_sim import drivers, scenarios
from vpf_sim.envs.camera import weather
from vpf_sim.gallery.weather_meaning import in_words

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "gallery.md"
PICTURES = "pictures/gallery"
NOT_DRIVING = ("keyboard", "neutral")  # a person, and nobody
NEWER = ("-v1", "-v2")  # versions of highway-env's environments with the road of an older one
HEAD = """# Gallery

**What does it look like?** Each picture shows 2.6 seconds of a drive: the camera's frames, with what the driver
perceives and plans if it shows them, and the road from above. The command below a picture makes a video of the whole
drive. Name [your own driver](tutorials/own-driver.md) in it instead.
`python scripts/figures/gallery.py` makes this page.

[Scenarios](#scenarios) · [highway-env's roads](#highway-envs-roads) · [weathers](#weathers) · [drivers](#drivers)
"""
ENDINGS = {
    "success": "arrives after {time_s:g} s",
    "collision": "collides with a {collided_with} after {time_s:g} s",
    "off_road": "leaves the road after {time_s:g} s",
    "stuck": "stands still after {time_s:g} s",
    "timeout": "does not arrive in {time_s:g} s",
}


@dataclass(frozen=True, slots=True)
class Shown:
    """A drive to show: the first that arrives, of all seeds of the first driver, then of the next."""

    name: str
    scenario: str
    weather: str
    drivers: tuple[str, ...]
    about: str = ""
    seeds: range = range(1)

    @property
    def file(self) -> str:
        return f"{self.name}.webp"


@dataclass(frozen=True, slots=True)
class Drive:
    """The drive that was drawn."""

    driver: str
    seed: int
    status: str
    collided_with: str
    time_s: float

    def __str__(self) -> str:
        return ENDINGS[self.status].format(**asdict(self))


@dataclass(frozen=True, slots=True)
class Section:
    title: str
    about: str
    drives: tuple[Shown, ...]


def sections() -> tuple[Section, ...]:
    """What the page shows."""
    known = {name: scenarios.load(name) for name in scenarios.names()}
    roads = [name for name, found in known.items() if isinstance(found, scenarios.HighwayScenario)]
    ours = [name for name in known if name not in roads]
    return (
        Section(
            "Scenarios",
            "Driven by `expert`, which gets the true world, or by `vpf` where it does not arrive.",
            tuple(Shown(name, name, "clear", ("expert", "vpf"), scenarios.summary(name), range(3)) for name in ours),
        ),
        Section(
            "highway-env's roads",
            "With highway-env's traffic, driven by its own driver, or by `expert` where that does not arrive. Newer "
            "versions (`-v1`, `-v2`) have the same roads: [highway-env's roads](highway-env.md).",
            tuple(
                Shown(name, name, "clear", ("idm", "expert"), scenarios.summary(name), range(6))
                for name in roads
                if not (name.endswith(NEWER) and _oldest(name) in roads)
            ),
        ),
        Section(
            "Weathers",
            "The same drive past the same parked car. A weather of your own is a short file: [weather](weather.md).",
            tuple(
                Shown(f"weather-{name}", "town04", name, ("expert",), in_words(one))
                for name, one in weather.PRESETS.items()
            ),
        ),
        Section(
            "Drivers",
            "Each on the paper's road, with two parked cars, in hard rain. What each gets beyond its camera, and how"
            " often it arrives: [which driver?](comparison.md). `keyboard` is [you](start.md#drive-yourself).",
            tuple(
                Shown(f"driver-{one.name}", "town04", "rain", (one.name,), one.summary)
                for one in drivers.describe()
                if one.name not in NOT_DRIVING
            ),
        ),
    )


def _oldest(name: str) -> str:
    return f"{name[:-3]}-v0"


def everything() -> Iterable[Shown]:
    """All drives of the page."""
    return (shown for section in sections() for shown in section.drives)


def text(drives: Mapping[str, Drive]) -> str:
    """The page, of the drives by the names of their pictures."""
    return "\n".join([HEAD, *(_section(section, drives) for section in sections())])


def _section(section: Section, drives: Mapping[str, Drive]) -> str:
    shown = "\n".join(_figure(one, drives[one.name]) for one in section.drives)
    return f'## {section.title}\n{section.about}\n\n<div class="gallery">\n\n{shown}\n</div>\n'


def _figure(shown: Shown, drive: Drive) -> str:
    """A picture with its command; empty lines make Markdown of what stands within the HTML."""
    title = shown.name.partition("-")[2] if shown.name.startswith(("weather-", "driver-")) else shown.name
    return f"""<div>

![{shown.scenario}, {shown.weather}, {drive.driver}]({PICTURES}/{shown.file})

**{title}**: {shown.about.removesuffix(".")}. `{drive.driver}` {drive}.

```sh
{command(shown, drive)}
```

</div>
"""


def command(shown: Shown, drive: Drive) -> str:
    """The command that drives it again, over two lines."""
    weather_is = "" if shown.weather == "clear" else f" --weather {shown.weather}"
    first = f"vpf-sim drive {shown.scenario}{weather_is} --driver {drive.driver}"
    return f"{first} \\\n  --seed {drive.seed} --video {shown.name}.mp4"


def stored(path: Path) -> dict[str, Drive]:
    """The drives that have been drawn, by the names of their pictures."""
    return {name: Drive(**one) for name, one in json.loads(path.read_text("utf-8")).items()} if path.exists() else {}


def store(path: Path, drives: Mapping[str, Drive]) -> None:
    """Write what `stored` reads."""
    path.write_text(json.dumps({name: asdict(one) for name, one in sorted(drives.items())}, indent=0) + "\n", "utf-8")
