"""A sweep on a real Dask scheduler makes the same records as this machine alone."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from short_scenario import write_short

from vpf_sim import cli
from vpf_sim.evaluation.sweeps.run_folder import read_lines

THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"), "1")


@contextmanager
def process(*command: str, cwd: Path) -> Iterator["subprocess.Popen[bytes]"]:
    environment = {**os.environ, **THREADS, "PYTHONPATH": f"{os.environ.get('PYTHONPATH', '')}:{cwd}"}
    with (cwd / "dask.log").open("ab") as log, subprocess.Popen(command, cwd=cwd, env=environment, stderr=log) as child:
        try:
            yield child
        finally:
            child.kill()


def dask(*arguments: str, cwd: Path) -> Any:
    return process(sys.executable, "-m", "dask", *arguments, cwd=cwd)


def worker(address: str, cwd: Path, name: str = "a", threads: str = "1") -> Any:
    return dask("worker", address, "--nthreads", threads, "--no-nanny", "--no-dashboard", "--name", name, cwd=cwd)


@contextmanager
def scheduling(tmp_path: Path) -> Iterator[tuple[str, "subprocess.Popen[bytes]"]]:
    """The address of a scheduler that has no worker yet, and its process."""
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    file = tmp_path / "scheduler.json"
    arguments = ("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    with dask(*arguments, cwd=tmp_path) as child:
        give_up = time.monotonic() + 60.0
        while not file.exists():
            assert time.monotonic() < give_up, (tmp_path / "dask.log").read_text()
            time.sleep(0.05)
        time.sleep(0.1)
        yield str(json.loads(file.read_text())["address"]), child


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    with scheduling(tmp_path) as (address, _):
        yield address


def sweep(folder: Path, out: Path, *more: str) -> list[str]:
    short = str(write_short(folder))
    grid = ["--scenario", short, "--driver", "pid", "--driver", "neutral", "--seeds", "0:4", "--out", str(out)]
    return [sys.executable, "-m", "vpf_sim.cli", "sweep", *grid, *more]


def contents(out: Path) -> tuple[list[str], str, list[str]]:
    """What must not depend on where it was driven."""
    lines = sorted((out / "episodes.jsonl").read_text().splitlines())
    return lines, (out / "summary.json").read_text(), sorted(path.name for path in (out / "steps").iterdir())


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_makes_the_same_records(tmp_path: Path, scheduler: str) -> None:
    subprocess.run(sweep(tmp_path, tmp_path / "local", "--workers", "1"), check=True, capture_output=True)
    out = tmp_path / "cluster"
    with ExitStack() as stack:
        workers = {name: stack.enter_context(worker(scheduler, tmp_path, name)) for name in "ab"}
        driving = subprocess.Popen(sweep(tmp_path, out, "--cluster", scheduler), stderr=subprocess.PIPE, text=True)
        stack.enter_context(driving)
        while not read_lines(out / "timing.jsonl"):
            assert driving.poll() is None, (driving.communicate()[1], (tmp_path / "dask.log").read_text())
            time.sleep(0.02)
        workers[read_lines(out / "timing.jsonl")[0]["worker"]].kill()
        said = driving.communicate()[1]
    assert driving.returncode == 0, said
    assert contents(out) == contents(tmp_path / "local")
    assert {row["worker"] for row in read_lines(out / "timing.jsonl")} == {"a", "b"}


@pytest.mark.slow
def test_a_lost_scheduler_is_reported_with_the_resume_command(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with scheduling(tmp_path) as (address, child), worker(address, tmp_path):
        driving = subprocess.Popen(sweep(tmp_path, out, "--cluster", address), stderr=subprocess.PIPE, text=True)
        while not read_lines(out / "episodes.jsonl"):
            assert driving.poll() is None, driving.communicate()[1]
            time.sleep(0.02)
        child.kill()
        said = driving.communicate()[1]
    assert driving.returncode == 2
    assert "Traceback" not in said
    *_, stopped, back, reason = said.splitlines()
    assert stopped == f"stopped with {len(read_lines(out / 'episodes.jsonl'))} of 8 episodes stored"
    assert back == f"go on with: vpf-sim sweep --out {out} --resume --cluster {address}"
    assert reason.startswith("vpf-sim: --cluster: lost the scheduler")


HANGING = """
import time

class Hanging:
    privileged = "none"
    def reset(self, setup): pass
    def act(self, observation): time.sleep(600)
"""


@pytest.mark.slow
def test_an_episode_that_hangs_on_a_cluster_is_given_up(tmp_path: Path, scheduler: str) -> None:
    (tmp_path / "mine.py").write_text(HANGING)
    out = tmp_path / "out"
    options = [
        "--driver",
        "mine:Hanging",
        "--seeds",
        "0:1",
        "--timeout",
        "15",
        "--out",
        str(out),
        "--cluster",
        scheduler,
    ]
    command = [sys.executable, "-m", "vpf_sim.cli", "sweep", "--scenario", str(write_short(tmp_path)), *options]
    nannied = ("worker", scheduler, "--nthreads", "1", "--no-dashboard")
    with dask(*nannied, cwd=tmp_path):
        done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    (record,) = read_lines(out / "episodes.jsonl")
    assert record["status"] == "error"
    (reason,) = (out / "errors").iterdir()
    assert "took longer than 15 s" in reason.read_text()
    assert f"see {reason}" in done.stderr
    assert "in act" in (tmp_path / "dask.log").read_text(), "the worker's log tells where it hung"


@pytest.mark.slow
@pytest.mark.parametrize("mixed", [False, True])
def test_workers_of_another_fingerprint(tmp_path: Path, scheduler: str, mixed: bool) -> None:
    out = tmp_path / "out"
    (tmp_path / "sitecustomize.py").write_text("import platform\nplatform.python_version = lambda: '3.99.0'\n")
    with worker(scheduler, tmp_path):
        command = sweep(tmp_path, out, "--cluster", scheduler, *["--mixed"] * mixed)
        done = subprocess.run(command, capture_output=True, text=True)
    if mixed:
        assert done.returncode == 0, done.stderr
        assert all(record["fingerprint"] for record in read_lines(out / "episodes.jsonl"))
    else:
        assert done.returncode == 2
        assert "another fingerprint: python: was " in done.stderr
        assert 'is "3.99.0"; --mixed accepts it' in done.stderr
        assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_worker_with_more_threads_is_refused(tmp_path: Path, scheduler: str) -> None:
    with worker(scheduler, tmp_path, threads="2"):
        command = sweep(tmp_path, tmp_path / "out", "--cluster", scheduler)
        done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "expected one thread (--nthreads 1), got 2" in done.stderr


def refused(arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The last line that a refused sweep says."""
    short = str(write_short(tmp_path))
    out = str(tmp_path / "out")
    assert cli.run(["sweep", "--scenario", short, "--driver", "neutral", "--out", out, *arguments]) == 2
    return capsys.readouterr().err.splitlines()[-1]


def test_without_dask_one_line_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    said = refused(["--cluster", "tcp://127.0.0.1:1"], tmp_path, capsys)
    assert said == "vpf-sim: --cluster: expected Dask, which is not installed: pip install 'vpf_sim[cluster]'"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://", "::"])
def test_no_scheduler_is_one_line(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    monkeypatch.setattr("vpf_sim.evaluation.sweeps.cluster.CONNECT_S", 1.0)
    said = refused(["--cluster", address], tmp_path, capsys)
    assert said.startswith(f"vpf-sim: --cluster: expected a Dask scheduler at {address}, got: ")
    assert not (tmp_path / "out").exists()


def test_workers_and_cluster_together_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(["--cluster", "tcp://127.0.0.1:1", "--workers", "2"], tmp_path, capsys)
    assert said == "vpf-sim: --workers: expected --workers or --cluster, got both; the cluster has its own workers"
