"""The gate: rules on run folders whose scores are known, and what is said of those that are broken."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest
from stored import record, store

from vpf_sim import cli
from vpf_sim.errors import InputError
from vpf_sim.evaluation import gate
from vpf_sim.evaluation.cells import read_run
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.plan import Plan
from vpf_sim.evaluation.rules import BOUNDS, Rule, read_rules
from vpf_sim.evaluation.summary import summarize

PLAN = Plan(("town04", "straight"), ("clear",), ("vpf",), "0:10")
Change = Callable[[Job], dict[str, Any] | None]


def run(path: Path, change: Change, plan: Plan = PLAN, world: str = "as it is") -> Path:
    """A run folder: a good record for each planned episode, with changes, or none where the change is None."""
    changes = {job: change(job) for job in plan.jobs()}
    rows = [record(job, **found) for job, found in changes.items() if found is not None]
    store(path, plan, rows, world)
    (path / "summary.json").write_text(json.dumps(summarize(plan.jobs(), rows)))
    return path


def checks(tmp_path: Path, rules: str, change: Change = lambda _: {}) -> list[gate.Check]:
    file = tmp_path / "rules.toml"
    file.write_text(rules)
    return gate.check(read_run(run(tmp_path / "run", change)), read_rules(file), file)


def only(tmp_path: Path, bound: str, change: Change) -> gate.Check:
    """The one check of a bound on town04."""
    (found,) = checks(tmp_path, f'[[rules]]\nscenario = "town04"\n{bound}', change)
    return found


def test_every_bound_of_the_rules_is_judged() -> None:
    assert set(gate.KINDS) == set(BOUNDS)


def lost(job: Job) -> dict[str, Any] | None:
    """Of ten seeds 3 has no record, 5 ended in a collision, 8 in an error."""
    ends = {5: {"status": "collision", "collisions": 1}, 8: {"status": "error", "path_mse_m2": None, "comfort": None}}
    return None if job.seed == 3 else ends.get(job.seed, {})


def spread(job: Job) -> dict[str, Any]:
    """Of ten seeds 3, 5 and 8 left the road; path MSE is seed / 10."""
    return {"path_mse_m2": job.seed / 10.0, "status": "off_road" if job.seed in (3, 5, 8) else "success"}


@pytest.mark.parametrize(
    ("change", "bound", "outcome", "actual", "seeds"),
    [
        (
            lost,
            "success_rate_at_least = 0.7",
            "passed",
            "0.7 over 10 episodes, 1 without a record, 1 ended by a fault",
            (),
        ),
        (
            lost,
            "success_rate_at_least = 0.71",
            "failed",
            "0.7 over 10 episodes, 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (
            lost,
            "success_rate_at_least = 0.70001",
            "failed",
            "0.7 over 10 episodes, 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (lost, "collisions_at_most = 3", "passed", "3 over 10 episodes, 1 without a record, 1 ended by a fault", ()),
        (
            lost,
            "collisions_at_most = 2",
            "failed",
            "3 over 10 episodes, 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (
            lost,
            "comfortable_share_at_least = 0.7",
            "passed",
            "0.7 over 10 episodes, 1 without a record, 1 ended by a fault",
            (),
        ),
        (
            lost,
            "comfortable_share_at_least = 0.8",
            "failed",
            "0.7 over 10 episodes, 1 without a record, 1 ended by a fault",
            (3, 5, 8),
        ),
        (
            lost,
            "path_mse_m2_at_most = 9",
            "failed",
            "0.4 m2 over 7 episodes, 1 without a record, 1 ended by a fault",
            (3,),
        ),
        (
            lost,
            "clearance_m_at_least = 0.6",
            "failed",
            "0.5 m over 7 episodes, 1 without a record, 1 ended by a fault",
            (3, 0, 1, 2, 4, 6, 7, 9),
        ),
        # the mean of 0, 1, 2, 4, 6, 7, 9 tenths is 29 / 70
        (spread, "path_mse_m2_at_most = 0.4143", "passed", "0.414 m2 over 7 episodes", ()),
        (spread, "path_mse_m2_at_most = 0.414", "failed", "0.4143 m2 over 7 episodes", (9, 7, 6)),
        (spread, "clearance_m_at_least = 0.5", "passed", "0.5 m over 7 episodes", ()),
        (spread, "clearance_m_at_least = 0.500001", "failed", "0.5 m over 7 episodes", (0, 1, 2, 4, 6, 7, 9)),
    ],
)
def test_bounds(change: Change, bound: str, outcome: str, actual: str, seeds: tuple[int, ...], tmp_path: Path) -> None:
    assert only(tmp_path, bound, change) == gate.Check(
        gate.Cell("town04", "clear", "vpf"), bound.replace(" = ", " "), actual, outcome, seeds
    )


def test_the_upper_end_of_the_interval_is_above_the_mean(tmp_path: Path) -> None:
    """Of 0.0, 0.1, ..., 0.9 the mean is 0.45, and Student's interval of it reaches to 0.667."""
    found = only(tmp_path, "path_mse_m2_upper_at_most = 0.55", lambda job: {"path_mse_m2": job.seed / 10.0})
    assert found.outcome == "failed"
    assert float(found.actual.split()[0]) == pytest.approx(0.667, abs=0.03)
    assert found.seeds == (9, 8, 7, 6)


def test_the_upper_end_where_all_are_equal_is_their_value(tmp_path: Path) -> None:
    assert only(tmp_path, "path_mse_m2_upper_at_most = 0.4", lambda _: {}).outcome == "passed"


def test_one_episode_has_no_upper_end_and_is_shown(tmp_path: Path) -> None:
    found = only(tmp_path, "path_mse_m2_upper_at_most = 9", lambda job: {} if job.seed == 4 else {"status": "stuck"})
    assert (found.outcome, found.actual, found.seeds) == ("failed", "no interval over 1 episode", (4,))


def test_without_bodies_there_is_no_clearance_to_keep(tmp_path: Path) -> None:
    found = only(tmp_path, "clearance_m_at_least = 0.3", lambda _: {"min_clearance_m": None})
    assert (found.outcome, found.actual) == ("skipped", "no bodies")


@pytest.mark.parametrize("bound", ["clearance_m_at_least = 0.0", "path_mse_m2_at_most = 99"])
def test_without_any_success_every_score_is_a_failure(bound: str, tmp_path: Path) -> None:
    found = only(tmp_path, bound, lambda _: {"status": "off_road", "min_clearance_m": None})
    assert (found.outcome, found.actual, found.seeds) == ("failed", "no successful episode", tuple(range(10)))


def test_a_rule_is_for_the_cells_that_it_names(tmp_path: Path) -> None:
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
def test_a_rule_for_no_cell_is_a_mistake(rule: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        checks(tmp_path, f"[[rules]]\n{rule}\ncollisions_at_most = 0")
    assert str(caught.value) == f"{tmp_path / 'rules.toml'}: " + sentence.format(run=tmp_path / "run")


AGAINST = '[[rules]]\nscenario = "town04"\nno_worse_than = "before{file}"\nscores = ["{score}"]'


def against(
    tmp_path: Path, score: str, change: Change, base: Change, file: str = "", seeds: str = "0:10"
) -> gate.Check:
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
def test_noise_gains_and_the_same_are_no_loss(change: Callable[[int], float], tmp_path: Path) -> None:
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


def test_a_baseline_of_another_world_is_refused(tmp_path: Path) -> None:
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
def test_what_is_no_summary_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "before").mkdir()
    (tmp_path / "before" / "summary.json").write_text(text)
    with pytest.raises(InputError, match=r"summary\.json: expected the summary\.json of a run, got something else"):
        checks(tmp_path, AGAINST.format(file="/summary.json", score="collisions"))


@pytest.mark.parametrize("score", ["path_mse_m2", "clearance_m"])
def test_an_episode_without_a_record_is_no_match_for_the_baseline(score: str, tmp_path: Path) -> None:
    found = against(tmp_path, score, lambda job: None if job.seed == 6 else {}, lambda _: {})
    assert (found.outcome, found.seeds) == ("failed", (6,))
    assert found.actual.endswith("on 9 same seeds, 1 without a record")


def test_what_there_never_was_cannot_get_worse(tmp_path: Path) -> None:
    found = against(tmp_path, "path_mse_m2", lambda _: {}, lambda _: {"status": "stuck"})
    assert (found.outcome, found.actual) == ("skipped", "the baseline has none")


def test_a_lost_score_is_a_failure(tmp_path: Path) -> None:
    found = against(tmp_path, "path_mse_m2", lambda _: {"status": "stuck"}, lambda _: {})
    assert (found.outcome, found.actual) == ("failed", "no successful episode")


RULES = [
    ("", "rules: expected at least one [[rules]], got none"),
    ("[[rules]]", "rules[0]: expected a bound, such as success_rate_at_least, or no_worse_than, got none"),
    ("[[rule]]", "rule: unknown key, did you mean 'rules'?"),
    ("rules = 3", "rules: expected a valid list, got 3"),
    ("rules = [1]", "rules[0]: expected a table, got 1"),
    (
        "[[rules]]\nsucess_rate_at_least = 1",
        "rules[0].sucess_rate_at_least: unknown key, did you mean 'success_rate_at_least'?",
    ),
    (
        "[[rules]]\nsuccess_rate_at_least = 95",
        "rules[0].success_rate_at_least: expected less than or equal to 1, got 95",
    ),
    ("[[rules]]\ncollisions_at_most = 0.5", "rules[0].collisions_at_most: expected a valid integer, got 0.5"),
    ("[[rules]]\npath_mse_m2_at_most = nan", "rules[0].path_mse_m2_at_most: expected a finite number, got nan"),
    (
        "[[rules]]\nclearance_m_at_least = -1",
        "rules[0].clearance_m_at_least: expected greater than or equal to 0, got -1",
    ),
    (
        '[[rules]]\ncollisions_at_most = 0\nscores = ["collisions"]',
        "rules[0].scores: expected some scores, and no_worse_than beside them",
    ),
    ("[[rules]", "expected TOML, got: "),
]


@pytest.mark.parametrize(("text", "sentence"), RULES)
def test_a_wrong_rules_file_is_told_by_file_and_key(
    text: str, sentence: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    folder, rules = run(tmp_path / "run", lambda _: {}), tmp_path / "rules.toml"
    rules.write_text(text)
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 2
    said = capsys.readouterr()
    assert said.err.startswith(f"vpf-sim: {rules}: {sentence}")
    assert said.err.count("\n") == 1
    assert said.out == ""


def test_a_wrong_rules_file_has_a_line_for_each_fault(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder, rules = run(tmp_path / "run", lambda _: {}), tmp_path / "rules.toml"
    rules.write_text('[[rules]]\ndriver = 3\n[[rules]]\nno_worse_than = "b"\nscores = ["sucess_rate"]')
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert first.endswith("rules[0].driver: expected a valid string, got 3")
    assert second.endswith("got 'sucess_rate': did you mean 'success_rate'?")


def spoil(name: str, text: str) -> Callable[[Path], None]:
    return lambda folder: (folder / name).write_text(text) and None


@pytest.mark.parametrize(
    ("harm", "sentence"),
    [
        (spoil("manifest.json", "[]"), "manifest.json: expected a table for plan and for fingerprint"),
        (spoil("manifest.json", "{"), "manifest.json: expected JSON, got something else"),
        (lambda folder: (folder / "manifest.json").unlink(), "manifest.json: expected the manifest of a run"),
        (spoil("episodes.jsonl", "[]\n"), "episodes.jsonl: line 1: expected a JSON object, got b'[]'"),
        (spoil("episodes.jsonl", '{"id": "a"}\n'), "episodes.jsonl: record 'a': status: got none"),
        (spoil("episodes.jsonl", '{"id": 3}\n'), "episodes.jsonl: record 3: id: expected a valid string, got 3"),
    ],
)
def test_a_torn_or_foreign_run_folder_is_one_clear_line(
    harm: Callable[[Path], None], sentence: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    folder, rules = run(tmp_path / "run", lambda _: {}), tmp_path / "rules.toml"
    rules.write_text("[[rules]]\ncollisions_at_most = 0")
    harm(folder)
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"vpf-sim: {folder}/{sentence}")
    assert said.count("\n") == 1


def test_the_command_says_what_failed_and_how_to_see_it(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder, rules = run(tmp_path / "run", lost), tmp_path / "rules.toml"
    rules.write_text('[[rules]]\nscenario = "town04"\nsuccess_rate_at_least = 0.9\ncollisions_at_most = 3')
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 1
    said = capsys.readouterr().out
    assert "FAIL town04, clear, vpf: expected success_rate_at_least 0.9, got 0.7 over 10 episodes, 1 without a" in said
    assert "again: for seed in 3 5 8; do vpf-sim drive town04 --weather clear --driver vpf --seed $seed; done\n" in said
    assert said.endswith("\n1 passed, 1 failed, 0 skipped\n")


def test_json_has_every_check_and_nothing_else(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder, rules = run(tmp_path / "run", lambda _: {}), tmp_path / "rules.toml"
    rules.write_text("[[rules]]\nsuccess_rate_at_least = 1\ncollisions_at_most = 0")
    assert cli.run(["check", str(folder), "--rules", str(rules), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["ok"] is True
    assert [(row["scenario"], row["outcome"], row["seeds"], row["rerun"]) for row in answer["checks"]] == [
        (scenario, "passed", [], None) for scenario in ("straight", "straight", "town04", "town04")
    ]


def test_names_are_quoted_for_the_shell() -> None:
    cell = gate.Cell("my road.toml", "clear", "my:Driver; rm -rf /")
    command = gate.Check(cell, "", "", "failed", (3,)).rerun
    assert command == "vpf-sim drive 'my road.toml' --weather clear --driver 'my:Driver; rm -rf /' --seed 3"


# Of Jenkins' junit-10.xsd: elements, what may stand in them, which attributes must and which may be there.
SCHEMA: dict[str, tuple[set[str], set[str], set[str]]] = {
    "testsuites": ({"testsuite"}, set(), {"name", "tests", "failures", "errors", "time"}),
    "testsuite": ({"testcase"}, {"name", "tests", "failures", "errors"}, {"skipped", "time", "timestamp", "file"}),
    "testcase": ({"failure", "skipped"}, {"name"}, {"classname", "time", "group"}),
    "failure": (set(), set(), {"message", "type"}),
    "skipped": (set(), set(), {"message", "type"}),
}


def valid(element: Xml.Element) -> bool:
    inside, needed, allowed = SCHEMA[element.tag]
    fits = needed <= set(element.keys()) <= needed | allowed and all(child.tag in inside for child in element)
    return fits and all(valid(child) for child in element)


def test_junit(tmp_path: Path) -> None:
    odd = '\x00\x1b[31m<&>" ]]> é \ufffe'

    def change(job: Job) -> dict[str, Any] | None:
        return {"min_clearance_m": None} if job.scenario == "straight" else spread(job)

    folder, rules, out = run(tmp_path / "run", change), tmp_path / "rules.toml", tmp_path / "new" / "out.xml"
    rules.write_text("[[rules]]\nsuccess_rate_at_least = 0.9\nclearance_m_at_least = 0.1")
    assert cli.run(["check", str(folder), "--rules", str(rules), "--junit", str(out)]) == 1
    root = Xml.fromstring(out.read_bytes())
    assert valid(root)
    cases = root.findall("testsuite/testcase")
    assert {(case.get("classname"), case.get("name"), case[0].tag if len(case) else "") for case in cases} == {
        ("straight.clear.vpf", "success_rate_at_least 0.9", ""),
        ("straight.clear.vpf", "clearance_m_at_least 0.1", "skipped"),
        ("town04.clear.vpf", "success_rate_at_least 0.9", "failure"),
        ("town04.clear.vpf", "clearance_m_at_least 0.1", ""),
    }
    for element in (root, root[0]):
        assert [element.get(key) for key in ("tests", "failures", "errors")] == ["4", "1", "0"]
    assert root[0].get("skipped") == "1"
    (failure,) = root.iter("failure")
    assert "for seed in 3 5 8; do vpf-sim drive town04" in str(failure.text)

    from vpf_sim.report.junit import write_junit

    write_junit([gate.Check(gate.Cell(odd, odd, odd), odd, odd, "failed", (1,))], out)
    (failure,) = Xml.fromstring(out.read_bytes()).iter("failure")
    assert '?[31m<&>" ]]> é ?' in str(failure.text)


DOCS = Path(__file__).parents[1] / "docs"


def test_the_example_rules_show_every_key() -> None:
    rules = read_rules(DOCS / "rules.toml")
    assert {key for rule in rules for key in rule.bounds()} == set(BOUNDS)
    assert [rule.no_worse_than for rule in rules] == [None, None, "baseline"]
    assert set(Rule.model_fields) - set(re.findall(r"^(\w+) =", (DOCS / "rules.toml").read_text(), re.M)) == {"driver"}


def test_the_commands_of_the_guide_exist(capsys: pytest.CaptureFixture[str]) -> None:
    commands = re.findall(r"vpf-sim (\w+ [^|\n]*)", (DOCS / "gate.md").read_text())
    assert {command.split()[0] for command in commands} == {"sweep", "check"}
    for command in commands:
        assert cli.run([*command.split(), "--help"]) == 0, command
        assert "Usage: vpf-sim" in capsys.readouterr().out


def test_every_key_of_the_rules_is_in_the_guide() -> None:
    assert set(Rule.model_fields) - {"scenario", "weather", "driver"} <= set(
        re.findall(r"`(\w+)`", (DOCS / "gate.md").read_text())
    )
