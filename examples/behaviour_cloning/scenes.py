"""The scenes of the training drives: a seed draws road, obstacles, start and weather."""

from dataclasses import dataclass

import numpy as np

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather
from vpf_sim.scenarios import RandomScenario, Scenario
from vpf_sim.seeding import stream

ROADS = {  # without obstacles: its share of the drives, and how far into it (m) a drive may begin
    "town04-clean": (3.0, 170.0),
    "curve-left": (1.0, 150.0),
    "curve-right": (1.0, 150.0),
    "straight": (0.5, 100.0),
    "random": (3.0, 0.0),
}
OBSTACLES = {"rows": (5.0, 0.0), "random": (3.0, 0.0), "town04": (3.0, 10.0), "traffic": (1.5, 0.0)}
USUAL_WEATHERS, USUAL_SHARE = ("clear", "rain"), 0.6  # of the drives; the others have any preset
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
    names = [*((name, False) for name in ROADS), *((name, True) for name in OBSTACLES)]
    shares = np.array([share for share, _ in (*ROADS.values(), *OBSTACLES.values())])
    name, has_obstacles = names[int(rng.choice(len(names), p=shares / shares.sum()))]
    text = _text(name, has_obstacles, rng)
    return Scene(scenarios.parse(text, f"training scene {seed}"), _weather(rng), has_obstacles)


def _text(name: str, has_obstacles: bool, rng: np.random.Generator) -> str:
    """The scenario as TOML: one of the catalog, begun elsewhere, askew, slower or faster, in any lane."""
    farthest_m = (OBSTACLES if has_obstacles else ROADS)[name][1]
    lane = 2 if name in OBSTACLES and name != "random" else int(rng.integers(1, 5))
    lines = ["schema = 1", f'base = "{name}"', "[ego]", f"lane = {lane}"]
    if name in ("random", "rows"):
        look = f'{{surface = "{rng.choice(SURFACES)}", verge = "{rng.choice(VERGES)}"}}'
        rows = "rows = [1, 4]" if has_obstacles else "rows = [0, 0]"
        lines += ["[random]", f"look = {look}", *([rows] if name == "random" else [])]
        lines += ["radius_m = [50.0, 400.0]"]
    lines += ["[vary]", '"ego.lateral_m" = [-0.7, 0.7]', '"ego.heading_deg" = [-8.0, 8.0]']
    lines += ['"ego.speed_mps" = [-4.0, 1.5]', f'"ego.s_m" = [0.0, {farthest_m}]']
    if name == "town04":  # parked cars anywhere, so that a short drive meets one
        lines += ['"bodies.s_m" = [-8.0, 60.0]', '"bodies.lateral_m" = [-1.0, 1.0]']
    return "\n".join(lines)


def _weather(rng: np.random.Generator) -> str:
    usual = rng.random() < USUAL_SHARE
    return str(rng.choice(USUAL_WEATHERS if usual else weather.names()))
