"""A small run: one driver that looks, one that does not, one that breaks down, and one that never begins."""

from dataclasses import dataclass
from math import sin
from pathlib import Path
from typing import Any

import numpy as np
from short_scenario import write_short

from vpf_sim import drivers
from vpf_sim.driver_interface import Command, Driver, Observation
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.episode import episode
from vpf_sim.evaluation.metrics.records import Timing, unscored
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.sweeps.manifest import Manifest
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder
from vpf_sim.types import Image

WEATHER, SEED = "rain", 3
STOPS_AT = 5


class Weaves(Driver):
    """Looks at every other frame, and steers to and fro."""

    @property
    def needs_next_frame(self) -> bool:
        return self.count % 2 == 0

    def reset(self, setup: Any) -> None:  # noqa: ARG002
        self.count = 0

    def act(self, observation: Observation) -> Command:
        self.count += 1
        return Command(0.1 / 3.0, 0.05 * sin(3.0 * observation.time_s))


class BreaksDown(Weaves):
    """Raises an exception at its sixth step."""

    uses_images = False

    def act(self, observation: Observation) -> Command:
        if self.count >= STOPS_AT:
            raise ZeroDivisionError("no more")
        return super().act(observation)


@dataclass(frozen=True)
class Driven:
    """The run, and what the episode of `Weaves` was, found without the code under test."""

    path: Path
    ids: dict[str, str]  # by the driver
    table: StepTable
    frames: list[Image]
    rewards: list[float]
    truths: list[dict[str, Any]]


def drive(root: Path) -> Driven:
    """Drive the run into a folder of `root`."""
    scenario = str(write_short(root, goal_m=8.0))
    made = {"weaves": Weaves, "breaks": BreaksDown, "never": BreaksDown}
    for name, kind in made.items():
        drivers.admit(name, kind)
    plan = Plan((scenario,), (WEATHER,), tuple(made), f"{SEED}:{SEED + 1}")
    folder = RunFolder(root / "run", Manifest.of("sweep", plan))
    ids, tables = {}, {}
    for job in plan.jobs():
        ids[job.driver] = job.id
        if job.driver == "never":
            folder.add(unscored(job), Timing(id=job.id))
            continue
        result = episode.run(*job)
        tables[job.driver] = result.steps
        steps.write(result.steps, folder.path / "steps" / f"{job.id}.parquet")
        folder.add(result.record, result.timing, result.traceback)
    folder.close()
    return Driven(folder.path, ids, tables["weaves"], *_driven_again(scenario, tables["weaves"]))


def _driven_again(scenario: str, table: StepTable) -> tuple[list[Image], list[float], list[dict[str, Any]]]:
    """The frames, rewards and ground truth that the environment gives for these actions."""
    world = FourLane(scenario, WEATHER, truth=("depth", "flow", "foe"))
    observed, info = world.reset(seed=SEED)
    frames, rewards, truths = [observed["image"]], [], [info]
    for action in np.column_stack([table.throttle, table.steering])[:-1]:
        observed, reward, _, _, info = world.step(action)
        frames.append(observed["image"])
        rewards.append(reward)
        truths.append(info)
    world.close()
    return frames, rewards, truths
