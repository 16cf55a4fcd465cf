"""The gate against a baseline: what counts as worse, by pairs and by intervals."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from gated_runs import PLAN, Change, checks, run

from vpf_sim.errors import InputError
from vpf_sim.evaluation.gate.checks import Check
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import Plan

AGAINST = '[[rules]]\nscenario = "town04"\nno_worse_than = "before{file}"\nscores = ["{score}"]'


def against(tmp_path: Path, score: str, change: Change, base: Change, file: str = "", seeds: str = "0:10") -> Check:
    """The one check of a score of town04 against a baseline."""
    run(tmp_path / "before", base, Plan(PLAN.scenario, PLAN.weather, PLAN.driver, seeds))
    (found,) = checks(tmp_path, AGAINST.format(file=file, score=score), change)
    return found


def mse(value: Callable[[int], float]) -> Change:
    return lambda job: {"path_mse_m2": value(job.seed)}


def test_on_the_same_seeds_a_small_but_steady_loss_is_found(tmp_path: Path) -> None:
    """It is much smaller than the spread over the seeds, so that the mean's own interval would hide it."""
    found = against(tmp_path, "path_mse_m2", mse(lambda k: k + 0.02 + 0.001 * k), mse(float))
    assert found.outcome == "failed"
    assert found.expected == "path_mse_m2 no worse than before"
    assert found.actual.startswith("4.52, was 4.5: +0.0245 [+0.02")
    assert found.actual.endswith("] on 10 same seeds")
    assert found.seeds == (9, 8, 7, 6, 5, 4, 3, 2, 1, 0)


@pytest.mark.parametrize("change", [lambda k: k + 0.02 * (-1) ** k, lambda k: k - 0.5, float])
def test_noise_gains_and_equal_scores_are_no_loss(change: Callable[[int], float], tmp_path: Path) -> None:
    found = against(tmp_path, "path_mse_m2", mse(change), mse(float))
    assert (found.outcome, found.seeds) == ("passed", ())


def ends(*bad: int) -> Change:
    return lambda job: {"status": "collision", "collisions": 1} if job.seed in bad else {}


@pytest.mark.parametrize("score", ["success_rate", "collisions", "comfortable_share"])
def test_shares_fall_by_more_than_their_interval(score: str, tmp_path: Path) -> None:
    """Bonett and Price's interval of one pair lost of ten holds 0, that of five does not."""
    assert against(tmp_path / "one", score, ends(4), ends()).outcome == "passed"
    five = against(tmp_path / "five", score, ends(1, 3, 5, 7, 9), ends())
    assert (five.outcome, five.seeds) == ("failed", (1, 3, 5, 7, 9))
    assert against(tmp_path / "better", score, ends(), ends(1, 3, 5, 7, 9)).outcome == "passed"


@pytest.mark.parametrize("file", ["", "/summary.json"])
@pytest.mark.parametrize("score", ["success_rate", "collisions", "comfortable_share", "path_mse_m2", "clearance_m"])
def test_on_other_seeds_the_baselines_interval_counts(score: str, file: str, tmp_path: Path) -> None:
    def bad(job: Job) -> dict[str, Any]:
        worse = {"path_mse_m2": 2.0, "min_clearance_m": 0.1}
        return worse if job.seed < 2 else {**worse, "status": "collision", "collisions": 1}

    def good(job: Job) -> dict[str, Any]:
        return {"path_mse_m2": 0.4 + 0.01 * job.seed, "min_clearance_m": 0.5 + 0.01 * job.seed}

    found = against(tmp_path / "worse", score, bad, good, file, seeds="20:30")
    assert found.outcome == "failed"
    assert found.actual.endswith("in the summary" if file else "on other seeds")
    assert against(tmp_path / "same", score, good, good, file, seeds="0:11").outcome == "passed"


def test_a_baseline_of_another_scenario_is_refused(tmp_path: Path) -> None:
    run(tmp_path / "before", lambda _: {}, world="with one more car")
    with pytest.raises(InputError, match=r"before: expected scenario 'town04' as in .*run, got another of that name"):
        checks(tmp_path, AGAINST.format(file="", score="collisions"))


def test_a_baseline_without_the_cell_is_refused(tmp_path: Path) -> None:
    run(tmp_path / "before", lambda _: {}, Plan(("straight",), ("clear",), ("vpf",), "0:2"))
    with pytest.raises(
        InputError, match=r"expected the cell town04, clear, vpf, got none; known: straight, clear, vpf"
    ):
        checks(tmp_path, AGAINST.format(file="", score="collisions"))


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"rows": 3}', '{"rows": [{"scenario": "town04"}]}', '{"rows": [1]}'])
def test_a_file_without_a_summary_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "before").mkdir()
    (tmp_path / "before" / "summary.json").write_text(text)
    with pytest.raises(InputError, match=r"summary\.json: expected the summary\.json of a run, got something else"):
        checks(tmp_path, AGAINST.format(file="/summary.json", score="collisions"))


@pytest.mark.parametrize("score", ["path_mse_m2", "clearance_m"])
def test_an_episode_without_a_record_is_no_match_for_the_baseline(score: str, tmp_path: Path) -> None:
    found = against(tmp_path, score, lambda job: None if job.seed == 6 else {}, lambda _: {})
    assert (found.outcome, found.seeds) == ("failed", (6,))
    assert found.actual.endswith("on 9 same seeds, 1 without a record")


def test_a_score_without_a_baseline_value_is_skipped(tmp_path: Path) -> None:
    found = against(tmp_path, "path_mse_m2", lambda _: {}, lambda _: {"status": "stuck"})
    assert (found.outcome, found.actual) == ("skipped", "the baseline has none")


def test_a_lost_score_is_a_failure(tmp_path: Path) -> None:
    found = against(tmp_path, "path_mse_m2", lambda _: {"status": "stuck"}, lambda _: {})
    assert (found.outcome, found.actual) == ("failed", "no successful episode")
