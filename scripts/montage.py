"""Draw the README's image: frames, the driver's perception, and its lateral cost.

python scripts/montage.py docs/pictures/montage.jpg
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from vpf_sim.evaluation.episode import episode
from vpf_sim.reporting import cost_view, overlay
from vpf_sim.reporting.pictures import jpeg, sheet
from vpf_sim.types import Camera, Image, Plan

SEED = 1003
QUALITY = 85


def moment(scenario: str, when: Callable[[Plan], bool]) -> tuple[Image, Plan]:
    """The first frame and plan of an episode that satisfy `when`."""
    found: list[tuple[Image, Plan]] = []

    def watch(frame: Image, plan: Plan | None) -> None:
        if plan is not None and not found and when(plan):
            found.append((frame.copy(), plan))

    episode.run(scenario, "clear", "vpf", SEED, watch)
    return found[0]


def nearest_m(plan: Plan) -> float:
    """Distance, m, to the nearest obstacle ahead."""
    ahead = plan.perception.obstacles.forward_m
    return float(np.min(ahead, where=ahead > 0.0, initial=np.inf))


def main() -> None:
    camera = Camera()
    straight = moment("straight", lambda plan: plan.perception.flow.pose[0] > 20.0)
    bend = moment("curve-right", lambda plan: plan.perception.road.curvature_per_m > 0.009)
    far = moment("town04", lambda plan: nearest_m(plan) < 18.0)
    near = moment("town04", lambda plan: nearest_m(plan) < 8.0)
    pictures = [
        straight[0],
        overlay.draw(*bend, camera),
        overlay.draw(*far, camera),
        cost_view.draw(far[1]),
        overlay.draw(*near, camera),
        cost_view.draw(near[1]),
    ]
    target = Path(sys.argv[1])
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(jpeg(sheet(pictures, 2), QUALITY))


if __name__ == "__main__":
    main()
