"""From the variant `full-frame` to the variant `robust`, one change at a time: the steps of the ablation.

Each step is a variant of its own: all changes up to its own are made, those after it are not. The lane planner needs
static obstacles, so both come in together.
"""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

Table = dict[str, Any]  # of a variant's file


@dataclass(frozen=True, slots=True)
class Change:
    """What a step takes over from the last variant: sections or keys; `held` has keys that a later step takes."""

    name: str
    summary: str
    takes: tuple[str, ...]
    held: Mapping[str, object] = field(default_factory=dict)


DECISIONS = tuple(f"lane_planner.lateral_cost.{key}" for key in ("memory", "latch", "beside"))
SPEED_LIMITS = tuple(f"lane_planner.{key}" for key in ("speed", "clear_distance", "recovery"))
CHANGES = (
    Change("flow", "flow: 20 frames a second, points spread over the road, checked forward and backward", ("flow",)),
    Change(
        "focus_of_expansion",
        "focus of expansion: derotated, RANSAC and reweighting; time to contact by the expansion of clusters",
        ("focus_of_expansion", "time_to_contact"),
    ),
    Change("obstacle-test", "obstacle map: absolute test against the noise instead of Otsu", ("obstacle_map.method",)),
    Change(
        "boundary-layer", "controller: boundary layers instead of sign, and the gains that go with them", ("gains",)
    ),
    Change(
        "camera_pitch",
        "pitching and mounting are taken out of flow and frames; speed and yaw rate replace a rough pose",
        ("camera_pitch", "odometry"),
    ),
    Change(
        "lane_planner",
        "planner: static obstacles, and the minimum of a lateral cost instead of the force",
        ("static_obstacles", "lane_planner", "paper_planner", "obstacle_map"),
        dict.fromkeys((*DECISIONS, "lane_planner.path", *SPEED_LIMITS)),
    ),
    Change(
        "memory",
        "lateral cost: leaving the last minimum or changing the side of a near obstacle costs",
        DECISIONS,
    ),
    Change(
        "least-jerk",
        "reference: a path to the minimum with least jerk, and its heading rate",
        ("lane_planner.path",),
    ),
    Change(
        "speed",
        "speed limits by bends, obstacles and sensing range; recovery",
        SPEED_LIMITS,
    ),
    Change("road", "road: how the edges of the carriageway are found and followed", ("road_edges",)),
    Change("moving_obstacles", "moving obstacles are overtaken or followed", ("moving_obstacles",)),
)


def steps(first: Table, last: Table, changes: Sequence[Change] = CHANGES) -> dict[str, tuple[str, Table]]:
    """Summary and table of each step by its name, in order; a change of which both variants think alike is none."""
    made: dict[str, tuple[str, Table]] = {}
    table = first
    for change in changes:
        after = taken_over(table, last, change)
        if after != table:
            made[change.name] = (change.summary, after)
        table = after
    return made


def taken_over(table: Table, other: Table, change: Change) -> Table:
    """A copy of a variant's table with what a change takes from another variant's."""
    after = deepcopy(table)
    for path in change.takes:
        put(after, path, deepcopy(at(other, path)))
    for path, value in change.held.items():
        put(after, path, value)
    return after


def at(table: Table, path: str) -> Any:
    """What stands at "section.key"; None where nothing does."""
    value: Any = table
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return value


def put(table: Table, path: str, value: Any) -> None:
    """Put a value, or with None nothing, at "section.key"."""
    *sections, last = path.split(".")
    for section in sections:
        table = table.setdefault(section, {})
    if value is None:
        table.pop(last, None)
    else:
        table[last] = value
