"""The episode loop: what drivers receive, what is recorded, and how episodes end."""

from collections.abc import Callable
from dataclasses import fields
from hashlib import sha256

import numpy as np
import pytest
from tiny_world import Constant, TinyWorld

from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.evaluation.episode.episode import read, roll_out


def test_an_episode_is_observed_driven_and_recorded_to_its_end() -> None:
    driver, pid = Constant(1.0, 0.25), Constant(0.5, -0.1)
    outcome = roll_out(TinyWorld(), driver, pid, seed=3)
    table = outcome.steps
    assert (outcome.status, len(table), outcome.traceback) == ("success", 10, None)
    assert table.x_m == pytest.approx(np.arange(11.0))
    assert table.y_m == pytest.approx(0.25 * np.arange(11.0))
    assert table.time_s == pytest.approx(np.arange(11.0) / 10.0)
    assert (table.throttle[:-1] == 1.0).all()
    assert (table.pid_steering[:-1] == -0.1).all()
    assert np.isnan([table.throttle[-1], table.pid_throttle[-1]]).all(), "nothing is commanded where it has ended"


def test_the_shadow_sees_every_state_that_the_driver_sees_and_no_other() -> None:
    driver, pid = Constant(), Constant(-1.0)
    roll_out(TinyWorld(), driver, pid, seed=0)
    assert len(driver.seen) == 10
    assert all(mine is theirs for mine, theirs in zip(driver.seen, pid.seen, strict=True))


def test_both_are_reset_for_each_episode() -> None:
    driver, pid, world = Constant(), Constant(), TinyWorld()
    for seed in (1, 2):
        roll_out(world, driver, pid, seed)
        assert driver.setup.seed == pid.setup.seed == seed
        assert len(driver.seen) == len(pid.seen) == 10


@pytest.mark.parametrize(("privileged", "route", "world"), [("none", 0, 0), ("route", 1, 0), ("world", 1, 1)])
def test_a_driver_receives_only_its_declared_privilege(privileged: str, route: bool, world: bool) -> None:
    driver = Constant()
    driver.privileged = privileged
    roll_out(TinyWorld(), driver, Constant(), seed=0)
    assert (driver.setup.route is not None, driver.setup.world is not None) == (route, world)


def test_nothing_of_the_world_reaches_an_unprivileged_driver() -> None:
    driver = Constant()
    roll_out(TinyWorld(), driver, Constant(), seed=0)
    assert {item.name for item in fields(Observation)} == {
        *("image", "time_s", "x_m", "y_m", "yaw_rad", "speed_mps", "yaw_rate_radps", "goal_m", "frame_time_s", "turn")
    }
    told = [*(getattr(driver.setup, item.name) for item in fields(DriverSetup))]
    told += [getattr(driver.seen[0], item.name) for item in fields(Observation)]
    modules = {type(value).__module__ for value in told}
    assert modules <= {"builtins", "numpy", "vpf_sim.types"}
    assert isinstance(driver.seen[0].x_m, float)


def test_a_privileged_driver_cannot_change_the_shadows_route() -> None:
    driver, pid = Constant(), Constant()
    driver.privileged = pid.privileged = "route"
    roll_out(TinyWorld(), driver, pid, seed=0)
    assert driver.setup.route is not None
    driver.setup.route[:] = 0.0
    assert pid.setup.route is not None
    assert pid.setup.route[5, 0] == 5.0


def test_the_hash_of_the_frames_is_that_of_all_their_bytes_in_order() -> None:
    outcome = roll_out(TinyWorld(), Constant(), Constant(), seed=3)
    frames = b"".join(np.full((6, 8, 3), 3 + step, np.uint8).tobytes() for step in range(10))
    assert outcome.frames_sha256 == sha256(frames).hexdigest()


class Blind(Constant):
    uses_images = False


def test_the_frame_hash_is_none_without_frames() -> None:
    assert roll_out(TinyWorld(), Blind(), Constant(), seed=3).frames_sha256 is None


class EachThird(Constant):
    """It looks at one frame of three."""

    @property
    def needs_next_frame(self) -> bool:
        return len(self.seen) % 3 == 0


def test_only_frames_that_the_driver_uses_are_rendered_and_hashed() -> None:
    world, driver = TinyWorld(), EachThird()
    outcome = roll_out(world, driver, Constant(), seed=3)
    assert world.looks == [step % 3 == 0 for step in range(1, 11)]
    assert [observation.image.size > 0 for observation in driver.seen] == [step % 3 == 0 for step in range(10)]
    frames = b"".join(np.full((6, 8, 3), 3 + step, np.uint8).tobytes() for step in range(0, 10, 3))
    assert outcome.frames_sha256 == sha256(frames).hexdigest()
    assert outcome.steps.looked.tolist() == [float(step % 3 == 0) for step in range(10)] + [0.0]


def test_a_watcher_changes_neither_the_hash_nor_the_drivers_frames() -> None:
    world, shown = TinyWorld(), []
    outcome = roll_out(world, EachThird(), Constant(), seed=3, watch=lambda image, _: shown.append(int(image[0, 0, 0])))
    assert shown == list(range(3, 13))
    assert outcome.frames_sha256 == roll_out(TinyWorld(), EachThird(), Constant(), seed=3).frames_sha256


def test_equal_episodes_have_equal_states_and_others_do_not() -> None:
    def states(steering: float) -> bytes:
        return roll_out(TinyWorld(), Constant(1.0, steering), Constant(), seed=0).steps.states()

    assert states(0.1) == states(0.1)
    assert states(0.1) != states(np.nextafter(0.1, 1.0))


class Scribbler(Constant):
    def act(self, observation: Observation) -> Command:
        observation.image[:] = 0
        return super().act(observation)


class Clumsy(Constant):
    """It fails at the fourth frame."""

    def act(self, observation: Observation) -> Command:
        command = super().act(observation)
        if len(self.seen) == 4:
            raise ZeroDivisionError("no fourth frame, please")
        return command


class Quitter(Constant):
    def act(self, observation: Observation) -> Command:  # noqa: ARG002
        raise SystemExit(5)


class Silent(Constant):
    def act(self, observation: Observation) -> Command:  # type: ignore[return]
        """It forgets to answer."""


@pytest.mark.parametrize(
    ("driver", "reason", "rows"),
    [
        (lambda: Clumsy(), "ZeroDivisionError: no fourth frame, please", 4),
        (lambda: Quitter(), "SystemExit: 5", 1),
        (lambda: Silent(), "TypeError: driver: act: expected a vpf_sim.Command, got None", 1),
        (lambda: Scribbler(), "ValueError: assignment destination is read-only", 1),
        (lambda: Constant(float("nan")), "ValueError: driver: Command: throttle: expected a finite number", 1),
        (
            lambda: Constant(0.0, float("inf")),
            "ValueError: driver: Command: steering: expected a finite number, got inf",
            1,
        ),
    ],
)
def test_a_drivers_exception_ends_its_episode_as_an_error(
    driver: Callable[[], Constant], reason: str, rows: int
) -> None:
    outcome = roll_out(TinyWorld(), driver(), Constant(), seed=0)
    assert outcome.status == "error"
    assert outcome.traceback is not None
    assert reason in outcome.traceback
    assert len(outcome.steps.rows) == rows


def test_an_exception_of_the_environment_ends_the_episode() -> None:
    world = TinyWorld()
    del world.route
    outcome = roll_out(world, Constant(), Constant(), seed=0)
    assert outcome.status == "success", "no driver needs the route"
    pid = Constant()
    pid.privileged = "route"
    outcome = roll_out(world, Constant(), pid, seed=0)
    assert outcome.status == "error"
    assert len(outcome.steps.rows) == 0


def test_commands_beyond_the_limits_are_clipped_and_recorded_so() -> None:
    outcome = roll_out(TinyWorld(), Constant(7.0, -0.5), Constant(), seed=0)
    assert outcome.steps.throttle[0] == 1.0
    assert outcome.steps.x_m[1] == 1.0


def test_an_invalid_frame_is_recorded() -> None:
    outcome = roll_out(TinyWorld(invalid_after=3), Constant(), Constant(), seed=0)
    assert (outcome.status, len(outcome.steps)) == ("invalid_frame", 3)
    fault = outcome.invalid_frame
    assert fault is not None
    assert (fault.frame, fault.time_s, fault.fault) == (3, 0.3, "stale")


def test_no_driver_receives_an_invalid_first_frame() -> None:
    driver = Constant()
    outcome = roll_out(TinyWorld(invalid_after=0), driver, Constant(), seed=0)
    assert (outcome.status, len(outcome.steps), len(driver.seen)) == ("invalid_frame", 0, 0)


def test_a_watcher_receives_every_frame() -> None:
    shown: list[tuple[int, object]] = []
    roll_out(
        TinyWorld(), Constant(), Constant(), 5, watch=lambda image, plan: shown.append((int(image[0, 0, 0]), plan))
    )
    assert shown == [(5 + step, None) for step in range(10)]


def test_an_observation_is_read_in_plain_floats() -> None:
    observed, _ = TinyWorld().reset(seed=0)
    observed["ego"] = np.array([1.0, -2.0, 0.5, 5.5, -0.1])
    observation = read(observed)
    assert (observation.x_m, observation.y_m, observation.yaw_rad) == (1.0, -2.0, 0.5)
    assert (observation.speed_mps, observation.yaw_rate_radps, observation.goal_m) == (5.5, -0.1, (10.0, 0.0))
