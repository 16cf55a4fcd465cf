"""The registry of drivers: names without weight, users' own classes, and what is refused."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bicycle import Bicycle

from vpf_sim import drivers
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.errors import InputError
from vpf_sim.types import Camera, Floats, Plan, VehicleModel

OWN = """
from vpf_sim import Command

class Own:
    privileged = "none"
    def reset(self, setup): pass
    def act(self, observation): return Command(0.5, -0.5)

class NoAct:
    privileged = "none"
    def reset(self, setup): pass

class Nosy(Own):
    privileged = "everything"

class Needy(Own):
    def __init__(self, network): pass

class Explosive(Own):
    def __init__(self): raise RuntimeError("no weights\\nat all")

instance = Own()
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "own_driver.py").write_text(OWN)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "own_driver", raising=False)
    return "own_driver"


def setup(route: Floats | None = None) -> DriverSetup:
    return DriverSetup(Camera(), VehicleModel(), 60.0, 5.55, (150.0, 0.0), 0, route)


def frame(level: int = 90) -> Observation:
    image = np.full((480, 640, 3), level, np.uint8)
    return Observation(image, 0.0, 0.0, 0.0, 0.0, 5.55, 0.0, (150.0, 0.0))


def test_the_registry_and_its_descriptions() -> None:
    assert drivers.names() == [
        "vpf",
        "vpf-paper",
        "vpf-literal",
        "pid",
        "pure-pursuit",
        "stanley",
        "idm",
        "expert",
        "lane-lines",
        "dominant-plane",
        "learned-bc",
        "learned-ppo",
        "keyboard",
        "neutral",
    ]
    told = {row.name: row.privileged for row in drivers.describe() if row.privileged != "none"}
    assert told == {"pid": "route", "pure-pursuit": "route", "stanley": "route", "idm": "world", "expert": "world"}
    for row in drivers.describe():
        assert drivers.create(row.name).privileged == row.privileged


def test_only_vision_drivers_look_at_the_frames(module: str) -> None:
    seeing = [name for name in drivers.names() if drivers.uses_images(drivers.create(name))]
    ours, rivals = ["vpf", "vpf-paper", "vpf-literal"], ["lane-lines", "dominant-plane"]
    assert seeing == [*ours, *rivals, "learned-bc", "learned-ppo", "keyboard"]
    assert drivers.uses_images(drivers.create(f"{module}:Own")), "who does not say is shown them"


def test_naming_the_drivers_loads_none_of_them() -> None:
    heavy = "{'highway_env', 'cv2', 'scipy', 'pandas', 'pydantic'}"
    code = f"import sys; from vpf_sim import drivers; drivers.describe(); print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_driver_without_a_scene_imports_none_of_scipys_large_modules() -> None:
    """The tracker of the scene alone uses one of them."""
    slow = "{'scipy.optimize', 'scipy.signal', 'scipy.stats'}"
    modules = "vpf_sim.drivers.perceiver, vpf_sim.evaluation.episode.episode, vpf_sim.evaluation.analysis.summary"
    code = f"import sys, {modules}; print(sorted({slow} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("name", ["vpf", "vpf-paper", "vpf-literal"])
def test_a_vision_driver_survives_a_frame_without_any_texture(name: str) -> None:
    driver = drivers.create(name)
    driver.reset(setup())
    assert driver.trace() is None  # type: ignore[attr-defined]
    for level in (90, 90, 0, 255):
        command = driver.act(frame(level))
        assert -1.0 <= command.throttle <= 1.0
        assert -1.0 <= command.steering <= 1.0
    assert isinstance(driver.trace(), Plan)  # type: ignore[attr-defined]


def test_reset_starts_the_same_episode_again() -> None:
    random = np.random.Generator(np.random.PCG64(4))
    frames = [random.integers(0, 255, (480, 640, 3), np.uint8) for _ in range(4)]
    driver = drivers.create("vpf")

    def commands() -> list[Command]:
        driver.reset(setup())
        return [
            driver.act(Observation(image, k / 60, k * 0.09, 0.0, 0.0, 5.55, 0.0, (150.0, 0.0)))
            for k, image in enumerate(frames)
        ]

    assert commands() == commands()


@pytest.mark.parametrize("name", ["pid", "pure-pursuit", "stanley"])
def test_a_route_driver_needs_a_route_and_follows_it(name: str) -> None:
    driver = drivers.create(name)
    with pytest.raises(InputError, match=f"driver {name}: expected a route in its setup, got none"):
        driver.reset(setup())
    driver.reset(setup(np.column_stack([np.arange(200.0), np.zeros(200)])))
    car = Bicycle(y_m=0.4, speed_mps=4.0)
    for _ in range(600):
        car.step(driver.act(car.observe()))
    assert car.y_m == pytest.approx(0.0, abs=0.02)
    assert car.speed_mps == pytest.approx(5.55, abs=0.05)


def test_neutral_touches_nothing() -> None:
    driver = drivers.create("neutral")
    driver.reset(setup())
    assert driver.act(frame()) == Command(0.0, 0.0)


def test_a_users_own_class(module: str) -> None:
    driver = drivers.create(f"{module}:Own")
    driver.reset(setup())
    assert driver.act(frame()) == Command(0.5, -0.5)


WRITE = "write own_driver:Own"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("vfp", "unknown driver 'vfp': did you mean 'vpf'?"),
        (
            "no_such_module:Own",
            "driver 'no_such_module:Own': cannot import 'no_such_module': No module named 'no_such_module'",
        ),
        ("own_driver:Won", f"driver 'own_driver:Won': module 'own_driver' has no class 'Won'; {WRITE}"),
        ("own_driver:instance", f"driver 'own_driver:instance': module 'own_driver' has no class 'instance'; {WRITE}"),
        ("own_driver:NoAct", "driver 'own_driver:NoAct': expected privileged, reset and act; missing: act"),
        ("own_driver:Nosy", "driver 'own_driver:Nosy': privileged: expected none, route or world, got 'everything'"),
        (":Own", "driver ':Own': cannot import '': Empty module name"),
    ],
)
@pytest.mark.usefixtures("module")
def test_what_is_no_driver_is_refused(name: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        drivers.create(name)
    assert str(caught.value) == message


def test_a_class_that_wants_arguments_is_refused(module: str) -> None:
    with pytest.raises(InputError, match="expected a class that is made without arguments"):
        drivers.create(f"{module}:Needy")


def test_a_users_own_failure_is_one_line_with_the_exception_behind_it(module: str) -> None:
    with pytest.raises(InputError) as caught:
        drivers.create(f"{module}:Explosive")
    assert str(caught.value) == "driver 'own_driver:Explosive': making it raised RuntimeError: no weights at all"
    assert isinstance(caught.value.__cause__, RuntimeError)


@pytest.mark.parametrize(
    ("source", "reason"), [("def (", "SyntaxError: "), ("raise OSError('no disk')", "OSError: no disk")]
)
def test_a_module_that_cannot_be_run_is_told(
    source: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "broken_driver.py").write_text(source)
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(InputError) as caught:
        drivers.create("broken_driver:Own")
    assert str(caught.value).startswith(f"driver 'broken_driver:Own': importing 'broken_driver' raised {reason}")
    assert "\n" not in str(caught.value)
