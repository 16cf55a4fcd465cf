"""One closed-loop episode: a driver in an environment, from reset to end."""

import gc
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from time import perf_counter
from traceback import format_exc

import numpy as np

from vpf_sim import drivers, process_state
from vpf_sim.driver_interface import Driver, DriverSetup, Observation
from vpf_sim.envs.four_lane import TURNS, FourLane
from vpf_sim.evaluation.environment import Environment, Observed
from vpf_sim.evaluation.episode.log import FrameHasher, StepLog
from vpf_sim.evaluation.episode.paired import matched, pid_without_obstacles
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, Timing, record_of
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import InvalidFrame, Outcome, StepTable
from vpf_sim.timing import Stopwatch
from vpf_sim.types import Image, Plan

Watcher = Callable[[Image, Plan | None], None]
NO_FRAME: Image = np.empty((0, 0, 3), np.uint8)


@dataclass(frozen=True, slots=True)
class EpisodeResult:
    record: Record
    steps: StepTable
    timing: Timing
    traceback: str | None  # of an error


def run(
    scenario: str,
    weather: str,
    driver: drivers.DriverLike,
    seed: int,
    watch: Watcher | None = None,
    name: str | None = None,
    inputs: RunInputs | None = None,
) -> EpisodeResult:
    """Drive one episode and score it; `watch` receives each frame with the driver's plan for it.

    `name` is the driver's in the record; by default, it is the one that leads to it.

    Without `watch`, only the frames that the driver uses are rendered; the drive is the same. Process settings that the
    driver changes are restored. Scenario and weather are those of a stored run where its `inputs` are given.
    """
    with process_state.preserved():
        job = Job(scenario, weather, name or drivers.name_of(driver), seed)
        result = _run(job, driver, watch, inputs or RunInputs())
    # The objects of an environment reference each other; without a collection here, old ones fragment the heap.
    gc.collect()
    return result


def _run(job: Job, driver: drivers.DriverLike, watch: Watcher | None, inputs: RunInputs) -> EpisodeResult:
    started_s, stopwatch = perf_counter(), Stopwatch()
    tested = drivers.create(driver)
    truth, frames = (("foe",), True) if drivers.uses_images(tested) else ((), watch is not None)

    world = inputs.scenario(job.scenario), inputs.weather(job.weather)
    with closing(FourLane(*world, truth=truth, frames=frames)) as env:
        with stopwatch.running():
            outcome = roll_out(env, tested, drivers.create("pid"), job.seed, watch, stopwatch.end_step)
        wall_s = perf_counter() - started_s
        if len(outcome.steps):
            pid_run = pid_without_obstacles(env.scenario, job.seed)
            outcome = replace(outcome, steps=matched(outcome.steps, pid_run))
        record = record_of(job, outcome, env.route, env.route_length_m)
    rate, stages_ms = len(outcome.steps) / wall_s, stopwatch.typical_ms()
    timing = Timing(id=job.id, wall_s=wall_s, steps_per_s=rate, stages_ms=stages_ms)
    return EpisodeResult(record, outcome.steps, timing, outcome.traceback)


def roll_out(
    env: Environment,
    driver: Driver,
    shadow: Driver,
    seed: int,
    watch: Watcher | None = None,
    tick: Callable[[], None] = lambda: None,
) -> Outcome:
    """Reset, then observe, act, step and record until the episode ends.

    The shadow driver's commands are recorded and not executed. `tick` is called once per step.
    """
    traceback, uses_frame = None, drivers.uses_images(driver)
    with FrameHasher() as frames:
        log = StepLog()
        try:
            observed, info = env.reset(seed=seed)
            driver.reset(setup_for(driver, env, seed))
            shadow.reset(setup_for(shadow, env, seed))
            ended = info["status"] != "running"
            while not ended:
                observation = read(observed)
                if uses_frame:
                    frames.add(observation.image)
                log.observe(observation, info, env, uses_frame)
                command = drivers.command_of(driver, observation)
                plan, uncertainty = drivers.trace_of(driver), drivers.uncertainty_of(driver)
                log.act(command, shadow.act(observation), plan, uncertainty)
                if watch is not None:
                    watch(observation.image, plan)
                tick()
                uses_frame = drivers.needs_next_frame(driver)
                action = np.array([command.throttle, command.steering])
                observed, _, terminated, truncated, info = env.step(action, with_frame=uses_frame or watch is not None)
                ended = terminated or truncated
            log.observe(read(observed), info, env, used=False)
            status = info["status"]
        except (Exception, SystemExit):
            status, traceback, info = "error", format_exc(), {}
    invalid_frame = InvalidFrame(**info["invalid_frame"]) if status == "invalid_frame" else None
    return Outcome(status, log.table(), info.get("collided_with"), frames.hexdigest(), traceback, invalid_frame)


def setup_for(driver: Driver, env: Environment, seed: int) -> DriverSetup:
    """The driver's setup; route and world only with the privilege that it declares."""
    return DriverSetup(
        camera=env.camera,
        vehicle=env.vehicle_model,
        rate_hz=env.rate_hz,
        speed_reference_mps=env.speed_reference_mps,
        goal_m=env.goal_m,
        seed=seed,
        route=None if driver.privileged == "none" else env.route.copy(),
        world=env.road if driver.privileged == "world" else None,
    )


def read(observed: Observed) -> Observation:
    """The driver's observation from the environment's; drivers never receive `info`."""
    x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps = observed["ego"].tolist()
    goal_x_m, goal_y_m = observed["goal"].tolist()
    time_s = float(observed["time"][0])
    goal_m = (goal_x_m, goal_y_m)
    image = observed.get("image", NO_FRAME)
    frame_time_s = float(observed["frame_time"][0]) if "frame_time" in observed else time_s
    turn = TURNS[int(observed.get("turn", 0))]
    return Observation(image, time_s, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps, goal_m, frame_time_s, turn)
