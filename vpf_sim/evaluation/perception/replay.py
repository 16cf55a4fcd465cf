"""A stored drive seen again: its frames are drawn where perception looks, and nobody plans or steers.

Sensors read what they read in the episode. So the driver that made the run perceives what it perceived then, to the
last bit, wherever code and machine are the same.
"""

import gc
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vpf_sim import drivers
from vpf_sim.errors import InputError
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.evaluation.episode.pose_playback import SAME, PosePlayback
from vpf_sim.evaluation.perception.scorer import DriveEvaluation, PerceptionScorer
from vpf_sim.evaluation.processes import pool
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.types import Driver, Observation, Perception

Record = dict[str, Any]


class StoredDrive(NamedTuple):
    """An episode of a run folder."""

    folder: Path
    record: Record

    def steps(self) -> StepTable:
        """What happened in it; InputError where that is not stored."""
        return steps.read(self.folder / "steps" / f"{self.record['id']}.parquet")


Evaluated = tuple[StoredDrive, list[DriveEvaluation]]


def replay(drives: Iterable[StoredDrive], names: Sequence[str], workers: int) -> Iterator[Evaluated]:
    """Each drive as each of the drivers of these names perceives it, in the order in which they are ready."""
    for name in names:
        if not drivers.sees(drivers.create(name)):
            raise InputError(f"driver '{name}': expected one that perceives, got one that looks at no frame")
    longest_first = sorted(drives, key=lambda drive: -drive.record["steps"])
    for done in pool.run(partial(judge, tuple(names)), longest_first, workers):
        if done.result is None:
            raise InputError(f"{done.task.record['id']}: {done.reason.splitlines()[0]}")
        yield done.task, done.result


def judge(names: Sequence[str], drive: StoredDrive) -> list[DriveEvaluation]:
    """One drive as each of some drivers perceives it; all of them see the same frames."""
    try:
        return _judge(names, drive)
    finally:
        gc.collect()  # a world's objects hold each other


def _judge(names: Sequence[str], drive: StoredDrive) -> list[DriveEvaluation]:
    record, table = drive.record, drive.steps()
    judges = [PerceptionScorer(len(table.rows)) for _ in names]
    perceivers = [drivers.create(name) for name in names]
    with closing(PosePlayback(record["scenario"], record["weather"], table, truth=("foe",))) as world:

        def show(row: int, seen: Sequence[Perception], info: dict[str, Any]) -> None:
            for each, perception in zip(judges, seen, strict=True):
                each.judge(row, perception, world, info)

        watch(world, table, record["seed"], dict(zip(names, perceivers, strict=True)), show)
        moved_m = world.moved_m
    far = (f"the car would now be up to {moved_m:.2f} m elsewhere: it was put where it was",) if moved_m > SAME else ()
    identity = (record["id"], record["scenario"], record["weather"], record["seed"])
    return [
        DriveEvaluation(
            *identity,
            name,
            record["states_sha256"],
            table.replaced(each.columns),
            each.lane_error_m,
            each.detections_table(),
            far,
        )
        for name, each in zip(names, judges, strict=True)
    ]


def watch(
    world: PosePlayback,
    table: StepTable,
    seed: int,
    perceivers: dict[str, Driver],
    show: Callable[[int, Sequence[Perception], dict[str, Any]], None],
) -> None:
    """Let drivers perceive the frames of a drive, up to the last in which a command was given.

    A frame is drawn where one of them looks. `show` is told of each row of the table what each perceived there, in
    their order, with the environment's info.
    """
    observed, info = world.reset(seed=seed)
    for driver in perceivers.values():
        driver.reset(setup_for(driver, world, seed))
    commands = np.stack([table.throttle, table.steering], axis=1)
    for row, command in enumerate(commands[:-1]):
        if not np.isfinite(command).all():  # here the driver of the run broke down
            break
        observation = read(observed)
        show(row, [_perceived(name, driver, observation, row) for name, driver in perceivers.items()], info)
        looks = any(map(drivers.looks, perceivers.values()))
        observed, _, _, _, info = world.step(command, look=looks)


def _perceived(name: str, driver: Driver, observation: Observation, row: int) -> Perception:
    try:
        seen = drivers.perception_of(driver, observation)
    except Exception as error:  # the driver's own
        raise InputError(f"driver '{name}': fails on frame {row}: {type(error).__name__}: {error}") from error
    if seen is None:
        raise InputError(f"driver '{name}': expected one that shows what it perceives, by `perceive` or `trace`")
    return seen
