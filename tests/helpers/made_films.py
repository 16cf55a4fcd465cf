"""Films by the project's own camera, with all truth known: speed, lens and mounting, and what is painted on top."""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path as File

import cv2
import numpy as np
import recorded_layouts as layouts

from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.gallery.poses import Path, ScriptedDrive
from vpf_sim.scenarios import Scenario
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Image

WIDTH_PX, HEIGHT_PX, RATE_HZ = 480, 270, 20.0
SPEED_MPS, START_M, LENGTH_M = 8.0, 20.0, 400.0
Paint = Callable[[Image], None]  # paints on a picture (H, W, 3), in place
PAINTED = {"lanes": 3, "lane_width_m": 3.5}
UNPAINTED = {"lanes": 1, "lane_width_m": 8.0, "look": {"edge_lines": "none"}}


@cache
def film(
    speed_mps: float = SPEED_MPS,
    seconds: float = 4.0,
    across_deg: float = 60.0,
    pitch_deg: float = 0.0,
    height_m: float = 1.4,
    weather: str = "clear",
    lines: bool = True,
    look: tuple[str, ...] = (),
    radius_m: float = np.inf,
) -> tuple[Image, ...]:
    """The pictures of a drive along a road of three lanes or a street without paint; `look` is switched on."""
    lane, road_keys = (2, PAINTED) if lines else (1, UNPAINTED)
    bend = {"kind": "arc", "length_m": LENGTH_M, "radius_m": radius_m}
    segment = bend if np.isfinite(radius_m) else {"kind": "line", "length_m": LENGTH_M}
    shown = {**road_keys.get("look", {}), **dict.fromkeys(look, True)}
    road = Scenario.model_validate(
        {
            "schema": 1,
            "road": {**road_keys, "look": shown, "segments": [segment]},
            "ego": {"lane": lane},
            "goal": {"s_m": LENGTH_M - 10.0},
        }
    )
    camera = Camera.of(
        WIDTH_PX, HEIGHT_PX, across_deg, height_m=height_m, pitch_rad=float(np.radians(pitch_deg)), forward_m=1.5
    )
    offset = road.road.lane_offset_m(lane)
    drive = ScriptedDrive(road, Path(START_M, speed_mps, lambda _: offset), Rig(camera), RATE_HZ)
    return tuple(shot.image for shot in drive.shots(weathers.load(weather), 1, round(seconds * RATE_HZ)))


def watermark(image: Image) -> None:
    """Sharp letters over the whole picture, as of a film agency."""
    for row in range(14, HEIGHT_PX, 30):
        cv2.putText(image, "PREVIEW   " * 9, (-(row % 40), row), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (250, 250, 250), 1)


def drops(image: Image) -> None:
    """Sharp drops that stay where they are on the glass."""
    _drops(image, 330)


def covered(image: Image) -> None:
    """A glass so full of drops that hardly anything of the scene is left."""
    _drops(image, 2500)


def _drops(image: Image, count: int) -> None:
    random = stream(5, "drops")
    for x, y, size in random.uniform([0, 0, 3], [WIDTH_PX, HEIGHT_PX, 7], (count, 3)):
        cv2.circle(image, (int(x), int(y)), int(size), (60, 60, 60), -1)
        cv2.circle(image, (int(x) - 1, int(y) - 1), max(1, int(size) // 3), (245, 245, 245), -1)


def cabin(image: Image) -> None:
    """A scratched bonnet, a mirror above and pillars at the sides, all with sharp texture."""
    random = stream(6, "bonnet")
    coarse = random.integers(20, 230, (HEIGHT_PX // 3, WIDTH_PX // 3), dtype=np.uint8)
    texture = cv2.resize(coarse, (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_CUBIC)
    where = np.zeros((HEIGHT_PX, WIDTH_PX), np.uint8)
    cv2.ellipse(where, (WIDTH_PX // 2, HEIGHT_PX + 30), (WIDTH_PX // 2 + 40, 105), 0, 0, 360, 1, -1)
    cv2.rectangle(where, (180, 0), (310, 55), 1, -1)
    where[:, :40] = where[:, -40:] = 1
    image[where > 0] = texture[where > 0][:, None]


def date_stamp(image: Image) -> None:
    """A date in a corner, and a logo in another."""
    cv2.rectangle(image, (0, HEIGHT_PX - 30), (230, HEIGHT_PX), (0, 0, 0), -1)
    cv2.putText(image, "2026-11-27 14:03", (6, HEIGHT_PX - 9), cv2.FONT_HERSHEY_SIMPLEX, 0.7, (255, 255, 255), 2)
    cv2.putText(image, "DASHCAM X1", (WIDTH_PX - 190, HEIGHT_PX - 9), cv2.FONT_HERSHEY_SIMPLEX, 0.9, (255, 210, 0), 2)


def write(
    folder: File, images: Sequence[Image], *paints: Paint, camera: str = "", motion: tuple[float, float] | None = None
) -> File:
    """The film in a folder; with keys of `camera` in drive.toml, and `motion` (m/s, rad/s) as a table."""
    painted = [np.array(image) for image in images]
    for image in painted:
        for paint in paints:
            paint(image)
    folder.mkdir(parents=True)
    layouts.video(folder / "film.mp4", painted, RATE_HZ)
    if camera:
        (folder / "drive.toml").write_text(f"schema = 1\n[camera]\n{camera}\n")
    if motion:
        rows = "".join(f"{k / RATE_HZ},{motion[0]},{motion[1]}\n" for k in range(len(images)))
        (folder / "signals.csv").write_text(f"time_s,speed_mps,yaw_rate_radps\n{rows}")
    return folder
