"""Perception on stored drives, in open loop: frames are re-rendered at their poses, and drivers only perceive.

Sensors repeat their values of the episode, so with the same code and machine the run's own driver perceives the same,
bit by bit.
"""

import gc
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vpf_sim import drivers
from vpf_sim.driver_interface import Driver, Observation
from vpf_sim.errors import InputError
from vpf_sim.evaluation import pool, steps
from vpf_sim.evaluation.environment import Info
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.evaluation.episode.pose_playback import TOLERANCE, PosePlayback
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.perception.scorer import DriveEvaluation, PerceptionScorer
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.types import Perception


class StoredDrive(NamedTuple):
    """An episode of a run folder."""

    folder: Path
    record: Record

    def steps(self) -> StepTable:
        """The step table; InputError where it is not stored."""
        return steps.read(self.folder / "steps" / f"{self.record.id}.parquet")


Evaluated = tuple[StoredDrive, list[DriveEvaluation]]


def replay(drives: Iterable[StoredDrive], names: Sequence[str], workers: int) -> Iterator[Evaluated]:
    """Yield each drive with its evaluation by every named driver, as they are ready."""
    for name in names:
        if not drivers.uses_images(drivers.create(name)):
            raise InputError(f"driver '{name}': expected one that perceives, got one that uses no frames")
    longest_first = sorted(drives, key=lambda drive: -drive.record.steps)
    for done in pool.run(partial(evaluate, tuple(names)), longest_first, workers):
        if done.result is None:
            raise InputError(f"{done.task.record.id}: {done.reason.splitlines()[0]}")
        yield done.task, done.result


def evaluate(names: Sequence[str], drive: StoredDrive) -> list[DriveEvaluation]:
    """The evaluation of each named driver on one drive, on the same frames."""
    try:
        return _evaluate(names, drive)
    finally:
        gc.collect()  # the objects of an environment reference each other


def _evaluate(names: Sequence[str], drive: StoredDrive) -> list[DriveEvaluation]:
    record, table = drive.record, drive.steps()
    scorers = [PerceptionScorer(len(table.rows)) for _ in names]
    perceivers = [drivers.create(name) for name in names]
    with closing(PosePlayback.of(record, table, RunInputs(drive.folder), truth=("foe",))) as world:

        def show(row: int, perceptions: Sequence[Perception], info: Info) -> None:
            for scorer, perception in zip(scorers, perceptions, strict=True):
                scorer.add(row, perception, world, info)

        perceive_drive(world, table, record.seed, dict(zip(names, perceivers, strict=True)), show)
        moved_m = world.largest_correction_m
    remarks = (
        (f"the car would now deviate by up to {moved_m:.2f} m; its stored poses are used",)
        if moved_m > TOLERANCE
        else ()
    )
    identity = (record.id, record.scenario, record.weather, record.seed)
    return [
        DriveEvaluation(
            *identity,
            name,
            record.states_sha256 or "",
            table.replaced(scorer.columns),
            scorer.lane_error_m,
            scorer.detections_table(),
            remarks,
        )
        for name, scorer in zip(names, scorers, strict=True)
    ]


def perceive_drive(
    world: PosePlayback,
    table: StepTable,
    seed: int,
    perceivers: dict[str, Driver],
    show: Callable[[int, Sequence[Perception], Info], None],
) -> None:
    """Let drivers perceive the frames of a drive, up to the last with a command.

    A frame is rendered if any driver uses it. `show` receives the table's row, the perception of each driver in order,
    and the environment's info.
    """
    observed, info = world.reset(seed=seed)
    for driver in perceivers.values():
        driver.reset(setup_for(driver, world, seed))
    commands = np.stack([table.throttle, table.steering], axis=1)
    for row, command in enumerate(commands[:-1]):
        if not np.isfinite(command).all():  # the run's driver failed here
            break
        observation = read(observed)
        show(row, [_perceived(name, driver, observation, row) for name, driver in perceivers.items()], info)
        uses_frame = any(map(drivers.needs_next_frame, perceivers.values()))
        observed, _, _, _, info = world.step(command, with_frame=uses_frame)


def _perceived(name: str, driver: Driver, observation: Observation, row: int) -> Perception:
    try:
        perception = drivers.perception_of(driver, observation)
    except Exception as error:  # raised by the driver
        raise InputError(f"driver '{name}': fails on frame {row}: {type(error).__name__}: {error}") from error
    if perception is None:
        raise InputError(f"driver '{name}': expected one that shows what it perceives, by `perceive` or `trace`")
    return perception
