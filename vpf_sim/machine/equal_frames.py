"""Whether this machine draws the frames that all others draw, by a table of their hashes.

The table is a promise to users, so it is recorded: `python scripts/frame_hashes.py` writes it anew after a change of
what frames show.
"""

import tomllib
from collections.abc import Iterator
from contextlib import closing
from hashlib import sha256
from importlib.resources import files
from itertools import product
from types import SimpleNamespace

import numpy as np

from vpf_sim.envs.camera import Renderer, Rig
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.camera.rig import preset
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.machine.installation import Check
from vpf_sim.scenarios.parts import CameraName
from vpf_sim.types import Camera

ROADS = ("town04", "curve-left", "random")
WEATHERS = ("ClearNoon", "CloudyNoon", "WetNoon", "HardRainNoon", "ClearNight")
SIZES = ((84, 84), (320, 240))
CAMERAS: tuple[CameraName, ...] = ("dash-cam", "phone")
QUICK = (ROADS[:1], WEATHERS, SIZES[:1], ())  # for the doctor
SEED = 5
AHEAD_M, STEP_M, FRAMES, GAP_S = (0.0, 13.0), 0.5, 3, 0.1  # places along the road; frames at each
TURN_RAD = 1.0 / 128.0  # from frame to frame
NEAREST_M = 1.0 / 1024.0  # to which poses are rounded
REMEDY = "results differ from those of other machines; report your processor, system and `vpf-sim doctor --json`"


def expected() -> dict[str, str]:
    """The hash of the frames by road, weather and size."""
    found: dict[str, str] = tomllib.loads(files(__package__).joinpath("frame_hashes.toml").read_text("utf-8"))
    return found


def drawn(
    roads: tuple[str, ...] = ROADS,
    names: tuple[str, ...] = WEATHERS,
    sizes: tuple[tuple[int, int], ...] = SIZES,
    cameras: tuple[CameraName, ...] = CAMERAS,
) -> Iterator[tuple[str, str]]:
    """Each combination of road, weather and size or camera, and the hash of the frames that are drawn here."""
    rigs = {f"{width}x{height}": Rig(_camera(width, height)) for width, height in sizes}
    rigs |= {name: preset(name) for name in cameras}
    for road in roads:
        with closing(FourLane(road, frames=False)) as env:
            env.reset(seed=SEED)
            for weather, (name, rig) in product(names, rigs.items()):
                renderer = Renderer(env.road, rig, weathers.load(weather), SEED)
                yield f"{road} {weather} {name}", _hash(renderer, env)


def _camera(width: int, height: int) -> Camera:
    return Camera(width, height, width / 2, width / 2, (width - 1) / 2, (height - 1) / 2)


def check() -> Check:
    """Whether the frames of a road in all kinds of weather are those of the table."""
    table, found = expected(), dict(drawn(*QUICK))
    wrong = [name for name, digest in found.items() if table.get(name) != digest]
    if wrong:
        return Check("equal frames", False, f"{len(wrong)} of {len(found)} differ: {', '.join(wrong)}", REMEDY)
    return Check("equal frames", True, f"{len(found)} of {len(found)} combinations of road, weather and size")


def _hash(renderer: Renderer, env: FourLane) -> str:
    """SHA-256 over frames from places along the ego's first heading, while it turns.

    Poses are rounded, as numpy's last bits differ.
    """
    digest, heading = sha256(), round(float(env.ego.heading), 6)
    ahead = np.array([np.cos(heading), np.sin(heading)])
    for index, (place_m, frame) in enumerate(product(AHEAD_M, range(FRAMES))):
        position = env.ego.position + (place_m + frame * STEP_M) * ahead
        ego = SimpleNamespace(position=np.round(position / NEAREST_M) * NEAREST_M, heading=heading + frame * TURN_RAD)
        digest.update(renderer.render(ego, index * GAP_S).tobytes())
    return digest.hexdigest()
