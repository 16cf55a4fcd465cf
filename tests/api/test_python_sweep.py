"""`vpf_sim.sweep` and `vpf_sim.Run`: from one call to data frames, in worker processes where that can be."""

import importlib
import multiprocessing
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from little_room import limited
from short_scenario import write_short

import vpf_sim
from vpf_sim import cli
from vpf_sim.drivers import RouteDriver
from vpf_sim.evaluation.sweeps.manifest import read_manifest

MODULE = """
import vpf_sim

class Ahead(vpf_sim.Driver):
    uses_images = False
    def act(self, observation): return vpf_sim.Command(0.5, 0.0)
"""
SCRIPT = f"""{MODULE}
import os
print("begins")
for driver, options in (("pid", {{"workers": 1, "progress": False}}), ([Ahead, Ahead(), "pid"], {{"out": "mine"}})):
    run = vpf_sim.sweep("short.toml", driver=driver, seeds="0:2", **options)
    print(run.records["status"].value_counts().to_dict(), set(run.timing["process"]) == {{os.getpid()}})
vpf_sim.sweep("short.toml", driver=Ahead, seeds="0:2", workers=2, out="refused")
"""


class Speed(vpf_sim.Driver):
    """Accelerates or brakes by its one parameter."""

    uses_images = False

    def __init__(self, throttle: float = 0.5) -> None:
        self.throttle = throttle

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:  # noqa: ARG002
        return vpf_sim.Command(self.throttle, 0.0)


def sweep(short: Path, driver: Any, **options: Any) -> vpf_sim.Run:
    return vpf_sim.sweep(**{"scenario": short, "driver": driver, "seeds": "0:2", "progress": False, **options})


def test_a_sweep_is_data_frames(short: Path) -> None:
    """One driver brakes and stands, which is no success; the other arrives."""
    run = sweep(short, {"brakes": Speed(-1.0), "goes": Speed()}, weather=["clear", "rain"])
    assert run.path.parent == Path("runs")
    success = run.table.set_index(["driver", "weather"])["success_rate"].to_dict()
    assert success == {(name, weather): float(name == "goes") for name in ("brakes", "goes") for weather in WEATHERS}
    assert len(run.records) == 8
    assert set(run.records.columns[:6]) == {"id", "scenario", "weather", "driver", "seed", "status"}
    assert set(run.comparisons["of"]) == {"weather", "driver"}
    steps = run.steps(run.records["id"].iloc[0])
    assert list(steps["throttle"].iloc[:3]) == [-1.0, -1.0, -1.0]


WEATHERS = ("clear", "rain")


def test_workers_drive_a_class_that_they_can_import(short: Path) -> None:
    run = sweep(short, OwnPid, seeds=[0], workers=2)
    assert os.getpid() not in set(run.timing["process"])
    assert read_manifest(run.path).plan["driver"] == [f"{__name__}:OwnPid"]


class OwnPid(RouteDriver):
    def __init__(self) -> None:
        super().__init__("pid")


def test_an_instance_is_driven_in_this_process(short: Path) -> None:
    assert set(sweep(short, [Speed(0.6), "neutral"]).timing["process"]) == {os.getpid()}


@pytest.fixture(scope="module")
def scripted(tmp_path_factory: pytest.TempPathFactory) -> "tuple[Path, subprocess.CompletedProcess[str]]":
    """A script's folder, from which the script is gone, and what it has printed."""
    folder = write_short(tmp_path_factory.mktemp("script")).parent
    (folder / "script.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, "script.py"], cwd=folder, capture_output=True, text=True, check=False)
    (folder / "script.py").unlink()
    return folder, done


def test_a_script_needs_no_guard_and_its_own_classes_drive(scripted: Any) -> None:
    """Workers do not run a user's script again; what they cannot make drives in the script's process, and is shown."""
    _, done = scripted
    assert done.stdout.splitlines() == ["begins", "{'success': 2} False", "{'success': 6} True"]
    assert [line.split()[0] for line in done.stderr.splitlines()[:6]] == [f"{k}/6" for k in range(1, 7)]


def test_a_class_of_a_script_is_refused_for_workers(scripted: Any) -> None:
    folder, done = scripted
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        "vpf_sim.errors.InputError: workers: driver '__main__:Ahead': other processes cannot make it; "
        "give a class that a module defines, without a key"
    )
    assert not (folder / "refused").exists()


def test_a_run_of_a_script_needs_the_script_no_more(
    scripted: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its drivers are found by no command, so none names them."""
    monkeypatch.chdir(scripted[0])
    Path("mine/summary.json").unlink()
    for command in ("report", "results", "score"):
        assert cli.run([command, "mine"]) == 0
        said = capsys.readouterr()
        assert "unknown" not in said.out + said.err
        assert "--driver __main__" not in said.out
        assert command != "results" or "--driver pid --seeds 0:2" in said.out
    assert set(vpf_sim.Run("mine").table["privileged"]) == {"none", "route"}


class Layers(Speed):
    """A driver that is iterable, as a network of layers is."""

    def __iter__(self) -> Iterator[int]:
        return iter((1, 2))


def test_an_iterable_driver_is_one_driver(short: Path) -> None:
    assert set(sweep(short, Layers()).records["driver"]) == {f"{__name__}:Layers()"}


@pytest.mark.usefixtures("in_one_process")
def test_python_is_told_how_to_go_on_in_python(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    module = f"{__name__}:Speed"
    with pytest.raises(OSError, match="parquet"), limited(3000):
        vpf_sim.sweep(short, driver=module, seeds="0:1", out="mine", workers=1)
    said = capsys.readouterr().err.splitlines()
    assert said[-1] == "go on with: vpf_sim.sweep(..., out='mine', resume=True)"
    assert list(sweep(short, module, seeds="0:1", out="mine", resume=True).records["status"]) == ["success"]


OWN = "give a class that a module defines, without a key"


@pytest.mark.parametrize(
    ("driver", "options", "sentence"),
    [
        ([Speed(), Speed(1.0)], {}, f"driver: two are called '{__name__}:Speed()'; name them: driver={{'a': ..., 'b'"),
        ({"pid": Speed()}, {}, "driver: 'pid' is the name of another driver; choose another key"),
        ({"vpf@paper": Speed()}, {}, "driver: 'vpf@paper' is the name of another driver; choose another key"),
        ({"mine:Own": Speed()}, {}, "driver: 'mine:Own' is the name of another driver; choose another key"),
        ({"ours": "vpf"}, {}, "driver: 'ours': expected a class or an instance, got 'vpf'; give names in a list"),
        ({"a": OwnPid}, {"workers": 2}, f"workers: driver 'a': other processes cannot make it; {OWN}"),
        ({"a": OwnPid}, {"timeout": 5}, f"timeout: driver 'a': other processes cannot make it; {OWN}"),
        (Speed(), {"cluster": "a:1"}, f"cluster: driver '{__name__}:Speed()': other processes cannot make it; {OWN}"),
        ("pid", {"cluster": "nowhere"}, "cluster: expected a Dask scheduler at nowhere, got: no HOST:PORT"),
        ("pid", {"cluster": "a:1", "workers": 2}, "workers: expected workers or cluster, got both"),
        ({1: Speed()}, {}, "driver: expected names as keys, got 1"),
        ("pid", {"cluster": 5}, "cluster: expected an address, got 5"),
        ("pid", {"scenario": 5}, "scenario: expected a name or a path, got 5"),
        ("pid", {"weather": ["clear", None]}, "weather: expected a name or a path, got None"),
        ("pid", {"out": 5}, "out: expected a name or a path, got 5"),
        ("pid", {"timeout": float("inf")}, "timeout: expected seconds, more than 0 and up to 1000000, got inf"),
        ("pid", {"workers": -1}, "workers: expected a whole number >= 1, got -1"),
        ("pid", {"timeout": "5"}, "timeout: expected seconds > 0, got '5'"),
        ("pid", {"seeds": []}, "seeds: expected 1 to 1000000 seeds, got []"),
        ("pid", {"seeds": [3, 3]}, "seeds: expected different seeds, got 3 twice"),
        ("pid", {"seeds": [3, -7]}, "seeds: expected whole numbers of up to 18 digits, got [3, -7]"),
        ("pid", {"seeds": 3}, "seeds: expected whole numbers of up to 18 digits, got 3"),
        ("pid", {"seeds": "5:2"}, "sweep: seeds: expected A:B with A below B, got '5:2', which holds no seed"),
        ([], {}, "sweep: driver: expected at least one, got none"),
        ("pid", {"resume": True}, "resume: expected the folder of the run in out, got none"),
    ],
)
def test_wrong_use_is_one_sentence(driver: Any, options: dict[str, Any], sentence: str, short: Path) -> None:
    with pytest.raises(vpf_sim.InputError) as caught:
        sweep(short, driver, **options)
    assert str(caught.value).startswith(sentence)
    assert list(short.parent.iterdir()) == [short], "nothing is left behind"


@pytest.mark.slow
def test_a_module_loaded_anew_is_driven_as_it_is_now(short: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a notebook, where a driver's module is edited between two sweeps."""
    monkeypatch.syspath_prepend(short.parent)
    file = short.parent / "edited_driver.py"
    file.write_text(MODULE)
    module = importlib.import_module("edited_driver")
    old = module.Ahead
    assert list(sweep(short, old, workers=1).records["status"]) == ["success"] * 2
    file.write_text(MODULE.replace("0.5", "-1.0") + "# brakes")
    module = importlib.reload(module)
    assert list(sweep(short, {"before": old}).records["status"]) == ["success"] * 2
    assert sweep(short, old).records["status"].iloc[0] == "success"
    run = sweep(short, module.Ahead, workers=1)
    assert set(run.records["status"]) != {"success"}
    assert len(run.records) == 2


def test_seeds_are_numbers_in_any_order(short: Path) -> None:
    run = sweep(short, Speed(), seeds=np.array([7, 3]))
    assert sorted(run.records["seed"]) == [3, 7]
    assert read_manifest(run.path).plan["seeds"] == "7,3"


def in_a_process_without_others(short: Path, out: str, options: dict[str, Any]) -> list[str]:
    return list(vpf_sim.sweep(short, driver="pid", seeds="0:2", out=out, progress=False, **options).records["status"])


def test_a_worker_of_a_pool_drives_in_its_own_process(short: Path) -> None:
    """Such a process is daemonic, so that it can start no workers."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        for out, options in (("default", {}), ("one", {"workers": 1})):
            assert pool.apply(in_a_process_without_others, (short, out, options)) == ["success"] * 2
        for options in ({"workers": 2}, {"timeout": 60.0}):
            with pytest.raises(
                vpf_sim.InputError, match=rf"^{next(iter(options))}: expected \w+ in a process that may start"
            ):
                pool.apply(in_a_process_without_others, (short, "refused", options))
    assert not Path("refused").exists()


@pytest.mark.slow
def test_threads_and_executors_sweep_as_any_process(short: Path) -> None:
    with ThreadPoolExecutor(2) as threads:
        tasks = [threads.submit(in_a_process_without_others, short, f"thread{i}", {"workers": 1}) for i in range(2)]
        assert [task.result() for task in tasks] == [["success"] * 2] * 2
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as processes:
        assert processes.submit(in_a_process_without_others, short, "own", {"workers": 2}).result() == ["success"] * 2


@pytest.mark.parametrize("is_theirs", [False, True])
def test_an_error_before_the_first_episode_leaves_no_folder_that_blocks(
    short: Path, monkeypatch: pytest.MonkeyPatch, is_theirs: bool
) -> None:
    def fails(*_: Any, **__: Any) -> None:
        raise RuntimeError("no process can be started")

    if is_theirs:
        Path("mine").mkdir()
    with monkeypatch.context() as patch:
        patch.setattr("vpf_sim.evaluation.pool.SPAWN.Process", fails)
        with pytest.raises(RuntimeError, match="no process can be started"):
            sweep(short, "pid", out="mine")
    assert Path("mine").exists() == is_theirs
    assert len(sweep(short, Speed(), out="mine", seeds=[4]).records) == 1


@pytest.mark.usefixtures("in_one_process")
def test_a_sweep_is_resumed(short: Path) -> None:
    run = sweep(short, "neutral", seeds=range(1), out="mine")
    refusal = r"^mine: expected an empty or new run folder, choose another out, or resume what is there$"
    with pytest.raises(vpf_sim.InputError, match=refusal):
        sweep(short, "neutral", seeds=range(1), out="mine")
    with pytest.raises(vpf_sim.InputError, match=r"^resume: driver 'a': expected one whose code can be compared"):
        sweep(short, {"a": Speed()}, seeds=range(1), out="mine", resume=True)
    before = (run.path / "episodes.jsonl").read_bytes()
    again = sweep(short, "neutral", seeds=range(1), out="mine", resume=True)
    assert (again.path / "episodes.jsonl").read_bytes() == before


def test_a_report_is_a_page_of_the_run(short: Path) -> None:
    run = sweep(short, Speed())
    written = vpf_sim.report("runs/latest", clips=0)
    assert (written.path, written.page) == (run.path, run.path / "report.html")
    assert vpf_sim.report(run, out="page.html", clips=0).page == Path("page.html")
    for page in (run.path / "report.html", Path("page.html")):
        assert "Speed" in page.read_text("utf-8")


@pytest.mark.parametrize("clips", [-1, "3", None])
def test_wrong_clips_are_refused(clips: Any) -> None:
    with pytest.raises(vpf_sim.InputError, match=r"^clips: expected a whole number >= 0, got "):
        vpf_sim.report("runs/latest", clips=clips)


@pytest.mark.usefixtures("short")
def test_what_is_no_run_is_refused() -> None:
    with pytest.raises(vpf_sim.InputError, match=r"^runs/latest: expected a run folder, got nothing of that name$"):
        vpf_sim.report("runs/latest")
    with pytest.raises(vpf_sim.InputError, match=r"^run: expected a name or a path, got None$"):
        vpf_sim.Run(None)  # type: ignore[arg-type]
