"""`vpf_sim.drive`: the same episode by name, class and instance, and as on the command line."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from little_room import limited
from short_scenario import write_short

import vpf_sim
from vpf_sim.drivers import RouteDriver
from vpf_sim.evaluation.sweeps.run_folder import read_lines


class Pid(RouteDriver):
    """The baseline as a user's own class."""

    def __init__(self) -> None:
        super().__init__("pid")


class Ahead(vpf_sim.Driver):
    uses_images = False

    def __init__(self, throttle: float = 0.5) -> None:
        self.throttle, self.acted = throttle, 0

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:  # noqa: ARG002
        self.acted += 1
        return vpf_sim.Command(self.throttle, 0.0)


class Lost(Ahead):
    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:  # noqa: ARG002
        raise KeyError("no such road")


def test_a_name_a_class_and_an_instance_drive_alike(short: Path) -> None:
    records = [vpf_sim.drive(short, driver=one, seed=3).record for one in ("pid", Pid, Pid())]
    assert [record["driver"] for record in records] == ["pid", f"{__name__}:Pid", f"{__name__}:Pid()"]
    assert len({record["states_sha256"] for record in records}) == 1
    assert not (short.parent / "runs").exists(), "nothing is stored unasked"


def test_the_record_is_the_one_of_the_command_line(short: Path) -> None:
    """Whose process has one thread for each numeric library."""
    write_short(short.parent, goal_m=8.0)
    record = vpf_sim.drive("short.toml", driver="vpf", weather="rain", seed=4).record
    options = ["--driver", "vpf", "--weather", "rain", "--seed", "4", "--json"]
    command = [sys.executable, "-c", "from vpf_sim.cli import main; main()", "drive", "short.toml", *options]
    answer = json.loads(subprocess.run(command, capture_output=True, text=True, check=False).stdout)
    assert record == {key: value for key, value in answer.items() if key != "timing"}


def test_steps_are_a_data_frame_of_the_motion(short: Path) -> None:
    """Full throttle is 3 m/s2, from the scenario's 5.55 m/s."""
    driver = Ahead(throttle=1.0)
    episode = vpf_sim.drive(short, driver=driver)
    steps = episode.steps
    assert driver.acted == episode.record["steps"] == len(steps) - 1, "the instance itself has driven"
    assert steps["speed_mps"].to_numpy() == pytest.approx(5.55 + 3.0 * steps["time_s"].to_numpy(), abs=0.02)
    assert np.isnan(steps["throttle"].iloc[-1])


def test_an_exception_of_the_driver_is_told(short: Path) -> None:
    episode = vpf_sim.drive(short, driver=Lost)
    assert episode.status == "error"
    assert episode.error.endswith("KeyError: 'no such road'\n")
    assert repr(episode).endswith("error, KeyError: 'no such road'>")


def test_a_seed_of_numpy_is_a_seed(short: Path) -> None:
    records = [vpf_sim.drive(short, driver="neutral", seed=seed).record for seed in (3, np.int64(3))]
    assert records[0] == records[1]
    assert type(records[1]["seed"]) is int


def test_a_class_of_a_function_is_a_driver_too(short: Path) -> None:
    class Local(Ahead):
        pass

    assert vpf_sim.drive(short, driver=Local).status == "success"


def test_an_episode_is_stored_where_it_is_asked_for(short: Path) -> None:
    named = vpf_sim.drive(short, driver=Ahead(), out="mine")
    assert named.path == Path("mine")
    assert read_lines(Path("mine/episodes.jsonl")) == [named.record]
    new = vpf_sim.drive(short, driver="neutral", out=True)
    assert new.path is not None
    assert new.path.parent == Path("runs")
    assert vpf_sim.Run(new.path).steps(new.record["id"]).equals(new.steps)


class Interrupts(Ahead):
    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:  # noqa: ARG002
        raise KeyboardInterrupt


@pytest.mark.parametrize("existed", [False, True])
def test_ctrl_c_leaves_what_was_there(existed: bool, short: Path) -> None:
    if existed:
        Path("mine").mkdir()
    with pytest.raises(KeyboardInterrupt):
        vpf_sim.drive(short, driver=Interrupts, out="mine")
    assert [*Path().rglob("mine*")] == ([Path("mine")] if existed else [])


def test_a_full_disk_leaves_no_half_run(short: Path) -> None:
    """The manifest fits, the steps do not; the exception is kept, as in a notebook."""
    with limited(3000), pytest.raises(OSError, match=r"steps.*\.parquet") as caught:
        vpf_sim.drive(short, driver=Ahead(), out="mine")
    assert not Path("mine").exists()
    assert caught.value.__traceback__ is not None
    assert vpf_sim.drive(short, driver=Ahead(), out="mine").status == "success"


class SaysItsPrivilege:
    """Not a subclass of `vpf_sim.Driver`."""

    uses_images = False

    def __init__(self) -> None:
        self.privileged = "route"

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        assert setup.route is not None

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:  # noqa: ARG002
        return vpf_sim.Command(0.5, 0.0)


def test_an_instance_says_its_privilege(short: Path) -> None:
    assert vpf_sim.drive(short, driver=SaysItsPrivilege).status == "success"


def test_a_video_shows_every_frame(short: Path) -> None:
    episode = vpf_sim.drive(short, driver=Ahead, video="drive.mp4")
    film = cv2.VideoCapture("drive.mp4")
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == episode.record["steps"]


def test_the_process_is_left_as_it_was(short: Path) -> None:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(3)
    try:
        vpf_sim.drive(short, driver="neutral")
        assert cv2.getNumThreads() == 3
    finally:
        cv2.setNumThreads(threads)


class NoAct:
    privileged = "none"

    def reset(self, setup: vpf_sim.DriverSetup) -> None: ...


class Nosy(Ahead):
    privileged = "everything"  # type: ignore[assignment]


class Needy(Ahead):
    def __init__(self, network: object) -> None: ...


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"driver": NoAct}, f"driver '{__name__}:NoAct': expected privileged, reset and act; missing: act"),
        ({"driver": NoAct()}, f"driver '{__name__}:NoAct()': expected privileged, reset and act; missing: act"),
        ({"driver": 5}, "driver 'builtins:int()': expected privileged, reset and act; missing: privileged, reset, act"),
        ({"driver": Nosy}, f"driver '{__name__}:Nosy': privileged: expected none, route or world, got 'everything'"),
        ({"driver": Needy}, f"driver '{__name__}:Needy': expected a class that is made without arguments: "),
        ({"driver": "vfp"}, "unknown driver 'vfp': did you mean 'vpf'?"),
        ({"weather": 5}, "weather: expected a name or a path, got 5"),
        ({"out": None}, "out: expected a name or a path, got None"),
        ({"out": "runs/latest"}, "runs/latest: expected another name: this one stands for the run that began last"),
        ({"video": "."}, "video: .: expected the name of a file, got a folder"),
        ({"weather": "claer"}, "unknown weather 'claer': did you mean 'clear'?"),
        ({"seed": -1}, "seed: expected a whole number of 1 to 18 digits, got -1"),
        ({"seed": "3"}, "seed: expected a whole number of 1 to 18 digits, got '3'"),
        ({"seed": True}, "seed: expected a whole number of 1 to 18 digits, got True"),
        ({"seed": 10**18}, "seed: expected a whole number of 1 to 18 digits, got 1000000000000000000"),
        ({"video": "vidoes/a.mp4"}, "video: vidoes/a.mp4: expected a folder that exists, found no vidoes"),
    ],
)
def test_wrong_use_is_one_sentence(options: dict[str, Any], sentence: str, short: Path) -> None:
    with pytest.raises(vpf_sim.InputError) as caught:
        vpf_sim.drive(short, **{"driver": "neutral", "out": "run", **options})
    assert str(caught.value).startswith(sentence)
    assert list(short.parent.iterdir()) == [short], "nothing is left behind"


def test_a_driver_of_the_working_directory_is_found_by_name(short: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (short.parent / "driver_of_mine.py").write_text(
        "import vpf_sim\nclass Mine(vpf_sim.Driver):\n def act(self, observation): return vpf_sim.Command(0.5, 0.0)\n"
    )
    monkeypatch.setattr(sys, "path", [str(short.parent), *sys.path])
    assert vpf_sim.drive(short, driver="driver_of_mine:Mine").status == "success"
