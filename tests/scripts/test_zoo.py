"""The zoo's page is made from run folders and manifests."""

import sys
from pathlib import Path

import pytest
import stored
from run_script import run_script

import vpf_sim
from vpf_sim import drivers
from vpf_sim.drivers.learned import manifest
from vpf_sim.evaluation.sweeps.plan import Plan

SCRIPT = Path(__file__).parents[2] / "scripts" / "zoo.py"
sys.path.append(str(SCRIPT.parent))

from zoo import curve  # noqa: E402


def made(folder: Path, *runs: Path) -> str:
    done = run_script(SCRIPT, *runs, "--out", folder / "zoo.md", "--pictures", folder / "pictures")
    assert done.returncode == 0, done.stderr
    return (folder / "zoo.md").read_text("utf-8")


@pytest.mark.usefixtures("in_one_process")
def test_the_page_has_a_row_a_driver_with_the_results_of_the_run(tmp_path: Path) -> None:
    plan = Plan(("crossing",), ("clear", "rain"), ("learned-bc", "pid"), "7:9")
    lost = {"status": "collision", "driving_score_2_1": 0.0}
    rows = [stored.record(job, **(lost if job.driver == "pid" else {"driving_score_2_1": 1.0})) for job in plan.jobs()]
    text = made(tmp_path, stored.store(tmp_path / "run", plan, rows))
    table = [line for line in text.splitlines() if line.startswith("| [`")]
    assert [line.split("`")[1] for line in table] == ["pid", "learned-bc"], "in the registry's order"
    assert "| the route |" in table[0]
    assert "| 0 of 4<br>0 to 60 % | 0.00 |" in table[0]
    assert "| 4 of 4<br>40 to 100 % | 1.00 |" in table[1]
    model = drivers.model_of("learned-bc")
    assert model is not None
    training = manifest.load(model).training
    assert training is not None
    section = text.partition("\n## learned-bc\n")[2]
    assert f"- Teacher: {training.expert}; {training.frames:,} decisions" in section
    assert f"- Make it again: `{training.command}`" in section
    assert "`vpf-sim drive crossing --driver learned-bc`" in section
    assert (
        "`vpf-sim sweep --scenario crossing --weather clear --weather rain --driver learned-bc --seeds 7:9`" in section
    )


@pytest.mark.usefixtures("in_one_process")
def test_the_picture_is_of_the_run(tmp_path: Path) -> None:
    run = vpf_sim.sweep("straight", driver="pid", seeds="3:4", out=tmp_path / "run", workers=1, progress=False)
    text = made(tmp_path, Path(str(run.path)))
    assert "![What pid sees and plans](pictures/pid.jpg)" in text
    assert (tmp_path / "pictures" / "pid.jpg").read_bytes()[:2] == b"\xff\xd8"


def test_pictures_that_are_not_below_the_page_are_refused_in_one_line(tmp_path: Path) -> None:
    plan = Plan(("crossing",), ("clear",), ("pid",), "7:8")
    run = stored.store(tmp_path / "run", plan, [stored.record(job) for job in plan.jobs()])
    options = ["--out", tmp_path / "docs" / "zoo.md", "--pictures", tmp_path / "elsewhere"]
    done = run_script(SCRIPT, run, *options)
    assert done.returncode == 1
    assert done.stderr.startswith("zoo.py: --pictures: expected a folder below")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        ((), "not recorded"),
        ((0.5,), "▁, loss 0.5 to 0.5 in 1 epochs"),
        ((0.8, 0.1, 0.5), "█▁▅, loss 0.8 to 0.5 in 3 epochs"),
    ],
)
def test_a_curve_falls_from_its_highest_bar_to_its_lowest(values: tuple[float, ...], shown: str) -> None:
    assert curve(values) == shown


def test_a_long_curve_keeps_its_ends() -> None:
    bars = curve([100.0 - step for step in range(100)]).partition(",")[0]
    assert (bars[0], bars[-1], len(bars)) == ("█", "▁", 24)
