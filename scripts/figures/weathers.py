"""Draw an image of one pose in six weathers, or in others by their names.

python scripts/figures/weathers.py docs/pictures/weathers.jpg
python scripts/figures/weathers.py docs/pictures/night.jpg ClearNight WetNight HardRainNight ClearDusk
"""

import sys
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.envs.camera import weather
from vpf_sim.gallery import page as gallery
from vpf_sim.gallery.poses import POSES
from vpf_sim.reporting.kit.clip import jpeg, sheet
from vpf_sim.types import Image

POSE = "car-ahead"
WEATHERS = ("ClearNoon", "ClearSunset", "FoggyNoon", "WetCloudyNoon", "MidRainyNoon", "HardRainNoon")
WIDTH_PX, QUALITY, NOISY_QUALITY = 480, 85, 58  # noise of the dark takes many bytes


def picture(name: str) -> Image:
    """The pose in a weather, with the weather's name."""
    pose = next(pose for pose in POSES if pose.name == POSE)
    small = cv2.resize(
        gallery.picture(pose, weather.load(name)), (WIDTH_PX, WIDTH_PX * 3 // 4), interpolation=cv2.INTER_AREA
    )
    for place, colour in (((13, 25), (20, 20, 20)), ((12, 24), (255, 255, 255))):
        cv2.putText(small, name, place, cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, 1, cv2.LINE_AA)
    return np.asarray(small, np.uint8)


def main() -> None:
    names = sys.argv[2:] or WEATHERS
    pictures = [picture(name) for name in names]
    quality = NOISY_QUALITY if any("Night" in name for name in names) else QUALITY
    target = Path(sys.argv[1])
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(jpeg(sheet(pictures, 3 if len(pictures) > 4 else 2), quality))


if __name__ == "__main__":
    main()
