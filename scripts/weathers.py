"""Draw the README's picture of the weather: the same place in six of them.

python scripts/weathers.py docs/pictures/weathers.jpg
"""

import sys
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.envs.camera import weather
from vpf_sim.evaluation.poses import POSES, SEED
from vpf_sim.types import Image

PLACE = "car-ahead"
WEATHERS = ("ClearNoon", "ClearSunset", "FoggyNoon", "WetCloudyNoon", "MidRainyNoon", "HardRainNoon")
LEAD_S, RATE_HZ = 3.2, 15.0  # of the way there, on which rain gathers on the glass
WIDTH_PX, QUALITY = 480, 85


def picture(name: str) -> Image:
    """The place in a weather, with the weather's name."""
    pose = next(pose for pose in POSES if pose.name == PLACE)
    drive = pose.drive(LEAD_S, RATE_HZ)
    *_, last = drive.shots(weather.load(name), SEED, round(LEAD_S * RATE_HZ) + 1)
    small = cv2.resize(last.image, (WIDTH_PX, WIDTH_PX * 3 // 4), interpolation=cv2.INTER_AREA)
    for place, colour in (((13, 25), (20, 20, 20)), ((12, 24), (255, 255, 255))):
        cv2.putText(small, name, place, cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, 1, cv2.LINE_AA)
    return np.asarray(small, np.uint8)


def main() -> None:
    pictures = [picture(name) for name in WEATHERS]
    rows = [np.hstack(pictures[i : i + 3]) for i in range(0, len(pictures), 3)]
    target = Path(sys.argv[1])
    target.parent.mkdir(parents=True, exist_ok=True)
    together = cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(target), together, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    main()
