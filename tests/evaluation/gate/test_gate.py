"""The gate: bounds on run folders whose scores are known."""

from pathlib import Path

import pytest
from gated_runs import Change, checks, lost, only, spread

from vpf_sim.errors import InputError
from vpf_sim.evaluation.gate.checks import Check
from vpf_sim.evaluation.gate.rules import BOUNDS, score_of
from vpf_sim.evaluation.gate.run_cells import Cell
from vpf_sim.evaluation.metrics.registry import with_rules


def test_every_bound_of_the_rules_has_a_check() -> None:
    assert {score_of(bound) for bound in BOUNDS} == set(with_rules())


@pytest.mark.parametrize(
    ("change", "bound", "outcome", "actual", "seeds"),
    [
        (
            lost,
            "success_rate_at_least = 0.7",
            "passed",
            "0.7 (10 episodes), 1 without a record, 1 ended by a fault",
            (),
        ),
        (
            lost,
            "success_rate_at_least = 0.71",
            "failed",
            "0.7 (10 episodes), 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (
            lost,
            "success_rate_at_least = 0.70001",
            "failed",
            "0.7 (10 episodes), 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (lost, "collisions_at_most = 3", "passed", "3 (10 episodes), 1 without a record, 1 ended by a fault", ()),
        (
            lost,
            "collisions_at_most = 2",
            "failed",
            "3 (10 episodes), 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (
            lost,
            "comfortable_share_at_least = 0.7",
            "passed",
            "0.7 (10 episodes), 1 without a record, 1 ended by a fault",
            (),
        ),
        (
            lost,
            "comfortable_share_at_least = 0.8",
            "failed",
            "0.7 (10 episodes), 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (
            lost,
            "path_mse_m2_at_most = 9",
            "failed",
            "0.4 m2 (7 episodes), 1 without a record, 1 ended by a fault",
            (3,),
        ),
        (
            lost,
            "clearance_m_at_least = 0.6",
            "failed",
            "0.5 m (7 episodes), 1 without a record, 1 ended by a fault",
            (3, 0, 1, 2, 4, 6, 7, 9),
        ),
        # the mean of 0, 1, 2, 4, 6, 7, 9 tenths is 29 / 70
        (spread, "path_mse_m2_at_most = 0.4143", "passed", "0.414 m2 (7 episodes)", ()),
        (spread, "path_mse_m2_at_most = 0.414", "failed", "0.4143 m2 (7 episodes)", (9, 7, 6)),
        (spread, "clearance_m_at_least = 0.5", "passed", "0.5 m (7 episodes)", ()),
        (spread, "clearance_m_at_least = 0.500001", "failed", "0.5 m (7 episodes)", (0, 1, 2, 4, 6, 7, 9)),
    ],
)
def test_bounds(change: Change, bound: str, outcome: str, actual: str, seeds: tuple[int, ...], tmp_path: Path) -> None:
    assert only(tmp_path, bound, change) == Check(
        Cell("town04", "clear", "vpf"), bound.replace(" = ", " "), actual, outcome, seeds
    )


def test_the_upper_end_of_the_interval_is_above_the_mean(tmp_path: Path) -> None:
    """Of 0.0, 0.1, ..., 0.9 the mean is 0.45, and Student's interval of it reaches to 0.667."""
    found = only(tmp_path, "path_mse_m2_upper_at_most = 0.55", lambda job: {"path_mse_m2": job.seed / 10.0})
    assert found.outcome == "failed"
    assert float(found.actual.split()[0]) == pytest.approx(0.667, abs=0.03)
    assert found.seeds == (9, 8, 7, 6)


def test_the_upper_end_of_equal_values_is_their_value(tmp_path: Path) -> None:
    assert only(tmp_path, "path_mse_m2_upper_at_most = 0.4", lambda _: {}).outcome == "passed"


def test_one_episode_has_no_upper_end_and_is_shown(tmp_path: Path) -> None:
    found = only(tmp_path, "path_mse_m2_upper_at_most = 9", lambda job: {} if job.seed == 4 else {"status": "stuck"})
    assert (found.outcome, found.actual, found.seeds) == ("failed", "no interval (1 episode)", (4,))


def test_clearance_is_skipped_without_obstacles(tmp_path: Path) -> None:
    found = only(tmp_path, "clearance_m_at_least = 0.3", lambda _: {"min_clearance_m": None})
    assert (found.outcome, found.actual) == ("skipped", "no obstacles")


@pytest.mark.parametrize("bound", ["clearance_m_at_least = 0.0", "path_mse_m2_at_most = 99"])
def test_without_success_every_score_fails(bound: str, tmp_path: Path) -> None:
    found = only(tmp_path, bound, lambda _: {"status": "off_road", "min_clearance_m": None})
    assert (found.outcome, found.actual, found.seeds) == ("failed", "no successful episode", tuple(range(10)))


def test_a_rule_applies_to_the_cells_that_it_names(tmp_path: Path) -> None:
    bound = "\ncollisions_at_most = 0\n"
    rules = f'[[rules]]{bound}[[rules]]\nscenario = "t*"\ndriver = "v?f"\nsuccess_rate_at_least = 1{bound}'
    found = [(one.cell.scenario, one.expected, one.outcome) for one in checks(tmp_path, rules)]
    assert found == [
        ("straight", "collisions_at_most 0", "passed"),
        ("town04", "collisions_at_most 0", "passed"),
        ("town04", "success_rate_at_least 1", "passed"),
    ], "what two rules ask for stands once"


@pytest.mark.parametrize(
    ("rule", "sentence"),
    [
        ('scenario = "twon04"', "rules[0].scenario: not in {run}: unknown scenario 'twon04': did you mean 'town04'?"),
        ('weather = "rain*"', "rules[0].weather: not in {run}: unknown weather 'rain*': known: clear"),
        ('driver = "vfp"', "rules[0].driver: not in {run}: unknown driver 'vfp': did you mean 'vpf'?"),
    ],
)
def test_a_rule_without_a_cell_is_an_error(rule: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        checks(tmp_path, f"[[rules]]\n{rule}\ncollisions_at_most = 0")
    assert str(caught.value) == f"{tmp_path / 'rules.toml'}: " + sentence.format(run=tmp_path / "run")


@pytest.mark.parametrize("driver", ["slow", "__main__:Mine", "my_module:Mine()", "my_module:make.<locals>.Mine"])
def test_a_driver_without_a_name_of_its_own_has_no_command(driver: str) -> None:
    """One of a notebook or script, or an instance."""
    assert Check(Cell("town04", "clear", driver), "", "", "failed", (3,)).rerun is None
    assert Check(Cell("town04", "clear", "my_module:Mine"), "", "", "failed", (3,)).rerun is not None


DETAILS = {
    "path_mse_parts_m2": {"clear_of_obstacles": 0.04, "passing": 9.0},
    "chattering": {"steering": {"direction_changes_per_s": 8.0}, "steering_rate_radps": {"p95": 0.25, "max": 1.0}},
    "perception": {
        "edge_error_10m_m": {"median": 0.05, "p95": 1.0},
        "foe_median_error_px": {"x": 3.0, "y": 4.0, "distance": 6.0},
        "objects": {"met": 4, "recall": 0.75, "precision": 0.5, "wrong_per_minute": 2.0},
    },
}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("clear_path_mse_m2_at_most", 0.04),
        ("steering_rate_radps_at_most", 0.25),
        ("steering_reversals_per_s_at_most", 8.0),
        ("edge_error_m_at_most", 0.05),
        ("foe_error_px_at_most", 6.0),
        ("recall_at_least", 0.75),
        ("precision_at_least", 0.5),
        ("false_positives_per_minute_at_most", 2.0),
    ],
)
def test_details_are_held_to_their_bound(key: str, value: float, tmp_path: Path) -> None:
    tighter = -0.01 if key.endswith("_at_most") else 0.01
    for limit, outcome in ((value, "passed"), (value + tighter, "failed")):
        folder = tmp_path / outcome
        folder.mkdir()
        assert only(folder, f"{key} = {limit}", lambda _: DETAILS).outcome == outcome


def test_details_that_no_record_has_are_skipped(tmp_path: Path) -> None:
    found = only(tmp_path, "recall_at_least = 1", lambda _: {})
    assert (found.outcome, found.actual) == ("skipped", "not measured")
