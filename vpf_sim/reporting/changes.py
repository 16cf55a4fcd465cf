"""Pictures of episodes whose ending changed between two runs: both videos, and both paths over the road."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from vpf_sim.errors import InputError
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import PATH_MSE
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting import clips, paths, video
from vpf_sim.reporting.clips import EpisodeClip
from vpf_sim.reporting.paths import Track
from vpf_sim.reporting.road_layout import layouts
from vpf_sim.reporting.run_data import RunData
from vpf_sim.reporting.two_runs import Pair, TwoRuns

STYLES = ("d1", "d0")  # of A and B
BEYOND_M = 15.0  # of the video of the other episode, beyond the failure


@dataclass(frozen=True, slots=True)
class Change:
    """An episode of both runs; pictures that cannot be made are None."""

    name: str
    endings: tuple[str, str]
    videos: tuple[EpisodeClip | None, EpisodeClip | None]
    above: Markup | None


def choose(pairs: Sequence[Pair], count: int) -> list[Pair]:
    """Up to `count` pairs with another ending, those that now fail first; else the one whose path changed most."""
    changed = sorted((pair for pair in pairs if pair.changed), key=lambda pair: pair.records[1].succeeded)
    if changed or not count:
        return changed[:count]
    driven = [pair for pair in pairs if all(record[PATH_MSE] is not None for record in pair.records)]
    return sorted(filter(_path_change, driven), key=_path_change, reverse=True)[:1]


def make(runs: TwoRuns, pair: Pair, notify: Callable[[str], None]) -> Change:
    """The pictures of a pair, with videos if PyAV is installed; `notify` receives why one is missing."""
    tables = [one.run.steps(job.id) for one, job in zip((runs.a, runs.b), pair.jobs, strict=True)]
    end_m = _place_m(pair, tables)
    videos = []
    for run, job, record in zip((runs.a, runs.b), pair.jobs, pair.records, strict=True):
        videos.append(_video(run, record, end_m, notify) if video.is_available() else None)
        notify(f"{job.id}: {'rendered' if videos[-1] else 'no video'}")
    first, second = (record.ending for record in pair.records)
    return Change(
        name(pair), (first, second), (videos[0], videos[1]), _above(runs.a.run.inputs, pair, tables, end_m, notify)
    )


def name(pair: Pair) -> str:
    """The id of an episode, or both where they differ."""
    one, other = pair.jobs
    return one.id if one == other else f"{one.id} and {other.id}"


def _path_change(pair: Pair) -> float:
    one, other = (record[PATH_MSE] or 0.0 for record in pair.records)
    return abs(one - other)


def _place_m(pair: Pair, tables: Sequence[StepTable | None]) -> float:
    """The place to show, along the route: the end of the episode that failed, or where the paths lie farthest apart."""
    failed = [
        table for record, table in zip(pair.records, tables, strict=True) if table is not None and not record.succeeded
    ]
    driven = [table for table in tables if table is not None]
    if failed:
        return min(float(table.route_m[-1]) for table in failed)
    if len(driven) < 2:
        return 0.0
    one, other = driven
    route_m = np.maximum.accumulate(other.route_m)
    apart_m = np.abs(one.lane_offset_m - np.interp(one.route_m, route_m, other.lane_offset_m))
    return float(one.route_m[apart_m.argmax()])


def _video(run: RunData, record: Record, end_m: float, notify: Callable[[str], None]) -> EpisodeClip | None:
    if not record.steps:
        return None
    try:
        return clips.make(run.run, record, end_m + BEYOND_M)
    except InputError as error:
        notify(f"{record.id} cannot be re-rendered: {error}")
        return None


def _above(
    inputs: RunInputs,
    pair: Pair,
    tables: Sequence[StepTable | None],
    end_m: float,
    notify: Callable[[str], None],
) -> Markup | None:
    """Both paths over the road, at the place where one failed."""
    scenario, seed = pair.jobs[0].scenario, pair.jobs[0].seed
    if not any(table is not None for table in tables):
        return None
    try:
        layout = layouts(inputs.scenario(scenario), [seed])[seed]
    except InputError as error:
        notify(f"{scenario} cannot be drawn: {error}")
        return None
    tracks = [
        Track(seed, style, record.succeeded, table)
        for style, record, table in zip(STYLES, pair.records, tables, strict=True)
        if table is not None
    ]
    return paths.zoom(layout, [layout], tracks, layout.route.start_s_m + end_m, name(pair))
