"""Two runs compared on the same episodes: pairs, verdicts, the page, and what cannot be compared."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from short_scenario import SHORT
from stored import record, store

import vpf_sim
from vpf_sim import cli
from vpf_sim.evaluation.analysis.statistics import Difference, Interval, paired_difference, paired_shares
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.registry import SUCCESS
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.reporting import changes, compare_page
from vpf_sim.reporting.two_runs import compared, open_two, verdict

SEEDS = range(12)
COLLIDED = {"status": "collision", "collided_with": "car"}


def run(path: Path, change: Callable[[Job], dict[str, Any]], world: str = "as it is", **plan: Any) -> Path:
    """A run of town04 with a record for each planned episode."""
    grid = {"scenario": ("town04",), "weather": ("clear",), "driver": ("vpf",), "seeds": "0:12", **plan}
    planned = Plan(**grid)
    return store(path, planned, [record(job, **change(job)) for job in planned.jobs()], world)


def before(job: Job) -> dict[str, Any]:
    return COLLIDED if job.seed < 3 else {"path_mse_m2": 0.5 + 0.01 * job.seed}


def after(job: Job) -> dict[str, Any]:
    """Seeds 0 and 1 now succeed, 11 no longer does, and the path is better by 0.2 to 0.31 m2."""
    return COLLIDED if job.seed in (2, 11) else {"path_mse_m2": 0.3}


def test_episodes_are_paired_by_scenario_weather_driver_and_seed(tmp_path: Path) -> None:
    a = run(tmp_path / "a", before, driver=("vpf", "pid"), weather=("clear", "rain"))
    b = run(tmp_path / "b", after, driver=("pid", "idm"), seeds="10:14")
    runs = open_two(a, b)
    assert [pair.jobs for pair in runs.pairs] == [
        (job, job) for job in (Job("town04", "clear", "pid", 10), Job("town04", "clear", "pid", 11))
    ]
    assert runs.left_out == (46, 6)
    assert runs.labels == ("a", "b")


@pytest.mark.parametrize(
    ("kind", "names", "cell"),
    [
        ("driver", ("vpf", "pid"), ("town04", "clear", "pid against vpf")),
        ("weather", ("clear", "rain"), ("town04", "rain against clear", "vpf")),
    ],
)
def test_one_driver_or_weather_each_is_paired_under_different_names(
    kind: str, names: tuple[str, str], cell: tuple[str, str, str], tmp_path: Path
) -> None:
    first, second = (
        run(tmp_path / name, change, **{kind: (name,)}) for name, change in zip(names, (before, after), strict=True)
    )
    runs = open_two(first, second)
    assert len(runs.pairs) == len(SEEDS)
    assert runs.labels == names
    assert list(runs.cells()) == [cell]


def test_scores_are_paired_differences(tmp_path: Path) -> None:
    runs = open_two(run(tmp_path / "a", before), run(tmp_path / "b", after))
    found = compared(runs.pairs)
    reached = [
        np.array([change(Job("town04", "clear", "vpf", seed)) != COLLIDED for seed in SEEDS])
        for change in (after, before)
    ]
    assert found[SUCCESS.key].difference == paired_shares(*reached)
    assert (found[SUCCESS.key].a, found[SUCCESS.key].b) == pytest.approx((9 / 12, 10 / 12))
    both = np.arange(3, 11)
    expected = paired_difference(np.full(8, 0.3), 0.5 + 0.01 * both)
    assert expected is not None
    assert found["path_mse_m2"].difference == expected
    assert (found["path_mse_m2"].verdict, found[SUCCESS.key].verdict) == ("better", "undecided")
    assert "perception.objects.recall" not in found, "no record has it"


@pytest.mark.parametrize(
    ("difference", "sign", "expected"),
    [
        (Difference(0.3, Interval(0.1, 0.5), 0.01, 20), 1, "better"),
        (Difference(0.3, Interval(0.1, 0.5), 0.01, 20), -1, "worse"),
        (Difference(-0.3, Interval(-0.5, -0.1), 0.01, 20), -1, "better"),
        (Difference(0.3, Interval(-0.1, 0.5), 0.2, 20), 1, "undecided"),
        (Difference(0.3, Interval(0.1, 0.5), 0.125, 4), 1, "undecided"),
        (Difference(0.3, None, 1.0, 1), 1, "undecided"),
        (Difference(0.0, None, 1.0, 9), 1, "same"),
    ],
)
def test_better_and_worse_need_interval_and_test(difference: Difference, sign: int, expected: str) -> None:
    assert verdict(difference, sign) == expected


def test_episodes_that_now_fail_are_shown_first(tmp_path: Path) -> None:
    runs = open_two(run(tmp_path / "a", before), run(tmp_path / "b", after))
    assert [pair.jobs[0].seed for pair in changes.choose(runs.pairs, 9)] == [11, 0, 1]
    assert len(changes.choose(runs.pairs, 2)) == 2


def test_where_no_ending_changed_the_most_changed_path_is_shown(tmp_path: Path) -> None:
    first = run(tmp_path / "a", lambda _: {})
    runs = open_two(first, run(tmp_path / "b", lambda job: {"path_mse_m2": 0.9 if job.seed == 5 else 0.5}))
    assert [pair.jobs[0].seed for pair in changes.choose(runs.pairs, 4)] == [5]
    assert changes.choose(open_two(first, run(tmp_path / "same", lambda _: {})).pairs, 4) == []


def test_one_run_twice_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = run(tmp_path / "a", before)
    assert cli.run(["report", str(folder), str(folder)]) == 2
    assert capsys.readouterr().err == f"vpf-sim: report: expected two runs, got {folder} twice\n"


def test_episodes_that_one_run_has_not_driven_are_left_out(tmp_path: Path) -> None:
    first, stopped = run(tmp_path / "a", before), run(tmp_path / "b", before)
    lines = (stopped / "episodes.jsonl").read_text().splitlines(keepends=True)
    (stopped / "episodes.jsonl").write_text("".join(lines[:5]))
    runs = open_two(first, stopped)
    assert len(runs.pairs) == 5
    assert runs.left_out == (7, 7)


def test_the_page_begins_with_the_answer(tmp_path: Path) -> None:
    runs = open_two(run(tmp_path / "a", before), run(tmp_path / "b", after))
    html = compare_page.make(runs, 4, lambda _: None)
    (title,) = re.findall(r"<h1>(.*)</h1>", html)
    assert title == "b against a: vpf on town04 — clear — seeds 0–11"
    first, second, third = re.findall(r"<li>(.*)</li>", html[: html.index("<figure>")])
    assert first.startswith("b reached the goal in 10 of 12 episodes, a in 9: 8 percentage points more often than a (")
    assert second == "Of 12 episodes 2 now reach the goal, 1 no longer do."
    assert third.startswith("Better: path MSE −0.265 m² (")
    order = [html.index(f'id="{name}"') for name in ("findings", "changes", "scores", "endings", "made")]
    assert order == sorted(order)
    assert re.findall(r'<details id="(\w+)" open>', html) == ["scores"]
    assert "<video" not in html, "nothing without a film"


def test_the_comparison_as_data(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = run(tmp_path / "a", before), run(tmp_path / "b", after)
    out = tmp_path / "page.html"
    assert cli.run(["report", str(a), str(b), "--out", str(out), "--clips", "0", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["report"], found["runs"], found["pairs"]) == (str(out), [str(a), str(b)], 12)
    assert found["overall"]["path_mse_m2"]["verdict"] == "better"
    assert [one["statuses"] for one in found["changed"]] == [
        ["collision", "success"],
        ["collision", "success"],
        ["success", "collision"],
    ]
    assert found["cells"][0]["success_rate"]["pairs"] == 12
    assert not (b / "compare.html").exists()


@pytest.mark.parametrize(
    ("plan", "world", "said"),
    [
        ({"seeds": "20:22"}, "as it is", "b has vpf on town04 — clear — seeds 20:22"),
        ({"scenario": ("straight",)}, "as it is", "b has vpf on straight — clear — seeds 0:12"),
        ({}, "changed", "of another content under the same name: clear, town04"),
    ],
)
def test_runs_without_a_common_episode_are_one_line(
    plan: dict[str, Any], world: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    a, b = run(tmp_path / "a", before), run(tmp_path / "b", before, world, **plan)
    assert cli.run(["report", str(a), str(b)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("vpf-sim: report: expected an episode that both runs have driven, got none: ")
    assert error.count("\n") == 1
    assert said in error
    assert not (b / "compare.html").exists()


class Stopping(vpf_sim.Driver):
    """Brakes and stays."""

    sees = False

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:  # noqa: ARG002
        return vpf_sim.Command(throttle=-1.0, steering=0.0)


def test_a_changed_ending_has_both_films_and_both_paths(tmp_path: Path) -> None:
    scenario = tmp_path / "short.toml"
    scenario.write_text(f"{SHORT}[limits]\ntime_s = 1.5\n")
    a = vpf_sim.drive(scenario, driver="pid", seed=3, out=tmp_path / "a").path
    b = vpf_sim.drive(scenario, driver=Stopping, seed=3, out=tmp_path / "b").path
    assert a is not None
    assert b is not None
    written = vpf_sim.report(a, b, clips=1)
    assert (written.path, written.page) == (b, b / "compare.html")
    assert written.page is not None
    html = written.page.read_text()
    part = html[html.index('id="changes"') : html.index('id="scores"')]
    videos = re.findall(
        r'<video [^>]*poster="(data:image/jpeg;[^"]{1000,})" src="(data:video/mp4;base64,[^"]{1000,})"', part
    )
    assert len(videos) == 2
    assert videos[0] != videos[1]
    assert [len(re.findall(rf'<path class="path {style}"', part)) for style in changes.STYLES] == [2, 2], (
        "legend and path"
    )
    assert "1 no longer do" in html
