"""The step log of an episode: state, command and ground truth at each step."""

from dataclasses import replace
from hashlib import sha256
from math import hypot, nan
from queue import SimpleQueue
from threading import Thread
from types import TracebackType

from vpf_sim.driver_interface import Command, Observation
from vpf_sim.envs.contacts import corners, solid_objects
from vpf_sim.envs.network import OnRoad
from vpf_sim.evaluation.environment import FilmedSurroundings, Info
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.truth import surroundings
from vpf_sim.evaluation.truth.perception_errors import PerceptionErrors
from vpf_sim.geometry import wrap_angle
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.timing import timed
from vpf_sim.types import Image, Perception, Plan

CREEPING_MPS = 0.5
NO_FOE_PX = (nan, nan)  # a stationary car has no focus of expansion


class StepLog:
    """Builds the step table: `observe` adds a row, `act` completes it; the last row has no command."""

    def __init__(self) -> None:
        self._steps: list[Step] = []
        self._perception_errors = PerceptionErrors()

    @timed("log")
    def observe(self, observation: Observation, info: Info, env: FilmedSurroundings, used: bool) -> None:
        """Add a row with the true state and the ground truth; `used` is whether the driver uses this frame."""
        observation = _with_true_state(observation, info)
        ego, network = env.ego, env.road.network
        self._perception_errors.observe(observation, env)
        others, (_, near) = solid_objects(ego), env.nearest
        lanes = network.lane_use(corners(ego), ego.place[0])
        true_left_m, true_right_m = surroundings.true_edges(ego, network)
        true_foe_x_px, true_foe_y_px = info.get("foe", NO_FOE_PX)
        self._steps.append(
            Step(
                time_s=observation.time_s,
                x_m=observation.x_m,
                y_m=observation.y_m,
                yaw_rad=observation.yaw_rad,
                speed_mps=observation.speed_mps,
                yaw_rate_radps=observation.yaw_rate_radps,
                route_m=info["route_m"],
                lane_offset_m=info["lane_offset_m"],
                clearance_m=info["clearance_m"],
                ttc_s=surroundings.time_to_collision(ego, others, lanes.in_one_lane),
                passing=float(surroundings.is_passing(ego, others)),
                outside=float(lanes.is_outside),
                in_lane=float(lanes.in_one_lane),
                **({} if near is None else _nearest(ego, near)),
                true_foe_x_px=true_foe_x_px,
                true_foe_y_px=true_foe_y_px,
                true_left_m=true_left_m,
                true_right_m=true_right_m,
                looked=float(used),
                free_m=surroundings.free_width_m(ego, others, network) if observation.speed_mps < CREEPING_MPS else nan,
            )
        )

    def act(self, command: Command, pid: Command, plan: Plan | None, uncertainty: float = nan) -> None:
        """Complete the row with the driver's command and how unsure it is, the PID's command, and the perception."""
        self._steps[-1] = self._steps[-1]._replace(
            throttle=command.throttle,
            steering=command.steering,
            pid_throttle=pid.throttle,
            pid_steering=pid.steering,
            uncertainty=uncertainty,
            **({} if plan is None else self._planned(plan)),
        )

    def _planned(self, plan: Plan) -> dict[str, float]:
        """The columns of a plan."""
        columns = {
            "reference_mps": plan.reference.speed_mps,
            "heading_error_rad": wrap_angle(self._steps[-1].yaw_rad - plan.reference.heading_rad),
            **(planned(plan.extra) if isinstance(plan.extra, MotionPlan) else {}),
        }
        if plan.perception is None:
            return columns
        return columns | perceived(plan.perception) | self._perception_errors.columns(plan.perception)

    def table(self) -> StepTable:
        return StepTable.of(self._steps)


def _with_true_state(observation: Observation, info: Info) -> Observation:
    """The observation with the true state instead of the sensors' values."""
    if "ego" not in info:
        return observation
    x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps = info["ego"].tolist()
    state = {"x_m": x_m, "y_m": y_m, "yaw_rad": yaw_rad, "speed_mps": speed_mps, "yaw_rate_radps": yaw_rate_radps}
    return replace(observation, **state)


def _nearest(ego: OnRoad, near: OnRoad) -> dict[str, float]:
    """The columns of the nearest object."""
    return {
        "near_bearing_rad": surroundings.bearing_rad(ego, near),
        "near_bumper_m": surroundings.bumper_gap_m(ego, near),
        "near_speed_mps": hypot(*near.velocity.tolist()),
    }


def planned(plan: MotionPlan) -> dict[str, float]:
    """The columns of the chosen motion, and the number of candidates that were rejected for each reason."""
    motion = plan.motion
    return {
        "motion_right_m": plan.shift_m,
        "motion_1s_mps": motion.speed_at(motion.time_s + 1.0),
        "motion_end_mps": float(motion.profile.speed_mps[0, -1]),
        "motion_cost": motion.cost,
        "motion_breaks_limit": float(motion.is_rejected),
        **{f"rejected_{reason}": float(count) for reason, count in motion.rejected._asdict().items()},
    }


def perceived(perception: Perception) -> dict[str, float]:
    """The columns of focus of expansion and road edges; those with confidence 0 are left out."""
    columns: dict[str, float] = {}
    expansion, road = perception.expansion, perception.road
    if expansion.confidence > 0.0:
        columns |= {"foe_x_px": expansion.x_px, "foe_y_px": expansion.y_px}
    if road.confidence > 0.0:
        left_m, right_m = surroundings.perceived_edges(road)
        columns |= {"seen_left_m": left_m, "seen_right_m": right_m}
    return columns


class FrameHasher:
    """A context manager: `add` each frame, read `hexdigest` after its end. Frames must not change."""

    def __init__(self) -> None:
        self._digest = sha256()
        self._frames = 0
        self._queue: SimpleQueue[Image | None] = SimpleQueue()
        self._thread = Thread(target=self._work, name="frame hasher", daemon=True)

    def __enter__(self) -> "FrameHasher":
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._queue.put(None)
        self._thread.join()

    def add(self, frame: Image) -> None:
        """Queue a frame; the thread reads it later."""
        self._frames += 1
        self._queue.put(frame)

    def hexdigest(self) -> str | None:
        """The hash; None without frames."""
        return self._digest.hexdigest() if self._frames else None

    def _work(self) -> None:
        while (frame := self._queue.get()) is not None:
            self._digest.update(frame.tobytes() if not frame.flags.c_contiguous else frame.data)
