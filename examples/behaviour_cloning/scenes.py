"""The scenes of the training drives: a seed draws road, obstacles, start and weather."""

from dataclasses import dataclass

import numpy as np

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather
from vpf_sim.scenarios import RandomScenario, Scenario
from vpf_sim.seeding import stream


@dataclass(frozen=True, slots=True)
class Kind:
    """A scenario of the catalog: its share of the drives, and where they begin."""

    share: float
    starts_m: tuple[tuple[float, float], ...] = ((0.0, 0.0),)  # behind its own start, one of these ranges
    any_lane: bool = False  # else its own lane


ROADS = {  # without obstacles
    "town04-clean": Kind(2.0, ((3.0, 170.0),), any_lane=True),
    "curve-left": Kind(1.0, ((1.0, 150.0),), any_lane=True),
    "curve-right": Kind(1.0, ((1.0, 150.0),), any_lane=True),
    "straight": Kind(0.5, ((0.5, 100.0),), any_lane=True),
    "random": Kind(2.0, any_lane=True),
}
OBSTACLES = {  # starts before the obstacles and actors, which a short drive would not meet otherwise
    "random": Kind(5.0, ((0.0, 20.0),), any_lane=True),
    "rows": Kind(4.0, ((0.0, 10.0),)),
    "town04": Kind(2.5, ((0.0, 10.0),)),
    "traffic": Kind(2.0),
    "oncoming": Kind(1.5, ((0.0, 20.0), (60.0, 75.0))),
    "cut-in": Kind(1.5, ((0.0, 3.0), (85.0, 95.0))),
    "stop-and-go": Kind(1.5),
    "crossing": Kind(2.0, ((0.0, 25.0), (70.0, 90.0), (135.0, 150.0))),
    "open-door": Kind(1.5, ((0.0, 20.0), (90.0, 115.0))),
    "random-events": Kind(2.0),
    "random-marks": Kind(1.5, any_lane=True),
    "random-shadows": Kind(1.5, any_lane=True),
    "rows-worn": Kind(2.0, ((0.0, 10.0),)),
    "random-dash-cam": Kind(1.5, any_lane=True),
    "random-phone": Kind(1.5, any_lane=True),
}
DRAWN = ("random", "rows")  # begin the names of scenarios that draw their road
USUAL_WEATHERS, USUAL_SHARE = ("clear", "rain", "ClearNight"), 0.6  # of the drives; the others have any preset
SURFACES = ("asphalt", "asphalt", "concrete", "dark")
VERGES = ("grass", "grass", "sand", "paved")


@dataclass(frozen=True, slots=True)
class Scene:
    scenario: Scenario | RandomScenario
    weather: str
    has_obstacles: bool


def draw(seed: int) -> Scene:
    """The scene of a seed."""
    rng = stream(seed, "training scene")
    kinds = [*((name, kind, False) for name, kind in ROADS.items())]
    kinds += [(name, kind, True) for name, kind in OBSTACLES.items()]
    shares = np.array([kind.share for _, kind, _ in kinds])
    name, kind, has_obstacles = kinds[int(rng.choice(len(kinds), p=shares / shares.sum()))]
    text = _text(name, kind, has_obstacles, rng)
    return Scene(scenarios.parse(text, f"training scene {seed}"), _weather(rng), has_obstacles)


def _text(name: str, kind: Kind, has_obstacles: bool, rng: np.random.Generator) -> str:
    """The scenario as TOML: one of the catalog, begun elsewhere, askew, slower or faster, in any lane."""
    lines = ["schema = 1", f'base = "{name}"', *([f"ego.lane = {rng.integers(1, 5)}"] if kind.any_lane else [])]
    if name.startswith(DRAWN):
        surface = "concrete" if name == "rows-worn" else rng.choice(SURFACES)
        lines += ["[random]", f'look = {{surface = "{surface}", verge = "{rng.choice(VERGES)}"}}']
        lines += ["radius_m = [50.0, 400.0]"]
        if name == "random":
            lines.append("rows = [1, 4]" if has_obstacles else "rows = [0, 0]")
    low_m, high_m = kind.starts_m[int(rng.integers(len(kind.starts_m)))]
    lines += ["[vary]", '"ego.lateral_m" = [-0.7, 0.7]', '"ego.heading_deg" = [-8.0, 8.0]']
    lines += ['"ego.speed_mps" = [-4.0, 1.5]', f'"ego.s_m" = [{low_m}, {high_m}]']
    if name == "town04":  # parked cars anywhere, so that a short drive meets one
        lines += ['"bodies.s_m" = [-8.0, 60.0]', '"bodies.lateral_m" = [-1.0, 1.0]']
    return "\n".join(lines)


def _weather(rng: np.random.Generator) -> str:
    usual = rng.random() < USUAL_SHARE
    return str(rng.choice(USUAL_WEATHERS if usual else weather.names()))
