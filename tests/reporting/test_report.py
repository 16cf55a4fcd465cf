"""The report: one self-contained page that begins with its answer, with the numbers of the summary."""

import json
import re
import shutil
from datetime import date
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import chromium
import numpy as np
import pytest
from driven_run import drive_run
from short_scenario import SHORT

from vpf_sim import cli
from vpf_sim.evaluation.analysis.rows import Row, read_summary
from vpf_sim.evaluation.analysis.statistics import paired_shares, share_interval
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, unscored
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.reporting import clips, headline, main_table, page
from vpf_sim.reporting.main_table import DRIVING, Order
from vpf_sim.reporting.run_data import open_run

VOID = {"meta", "link", "br"}
BLOCKED = SHORT + '[[bodies]]\nkind = "barrier"\ns_m = 9.0\nlane = 2\n'
ORDER = Order(("town04-clean", "town04"), ("clear", "rain"), ("vpf", "pid"))


class Reader(HTMLParser):
    """Whether tags are closed in order, what the page refers to, its parts, and the numbers of its main table."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.stack: list[str] = []
        self.links: list[str] = []
        self.tags: list[str] = []
        self.data: list[tuple[float, str]] = []  # exact, shown
        self.parts: list[tuple[str, bool]] = []  # id of each section and details, and whether it is open
        self.media: list[dict[str, str | None]] = []
        self._exact: float | None = None
        self.feed(html)
        assert self.stack == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        found = dict(attrs)
        self.links += [value or "" for key, value in attrs if key in ("href", "src", "poster", "srcset", "xlink:href")]
        if tag in ("section", "details"):
            self.parts.append((found["id"] or "", tag == "section" or "open" in found))
        if tag in ("video", "img", "audio", "source"):
            self.media.append(found)
        if tag == "data":
            self._exact = float(found["value"] or "nan")
        if tag not in VOID:
            self.stack.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:  # noqa: ARG002
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.stack.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._exact is not None:
            self.data.append((self._exact, data))
            self._exact = None


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two scenarios, of which a barrier ends the second."""
    root = tmp_path_factory.mktemp("report")
    scenarios = []
    for name, text in (("open", SHORT), ("barred", BLOCKED)):
        (root / f"{name}.toml").write_text(text)
        scenarios.append(str(root / f"{name}.toml"))
    plan = Plan(tuple(scenarios), ("clear",), ("vpf", "pid"), "3:5")
    return drive_run(root / "run", plan)


@pytest.fixture(scope="module")
def written(run: Path) -> Path:
    assert cli.run(["report", str(run), "--clips", "1"]) == 0
    return run / "report.html"


def rows_of(run: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads((run / "summary.json").read_text())["rows"]
    return rows


def test_the_page_is_complete_and_loads_nothing(written: Path) -> None:
    html = written.read_text()
    reader = Reader(html)
    assert {tag: reader.tags.count(tag) for tag in ("h1", "video", "script")} == {"h1": 1, "video": 1, "script": 0}
    assert all(link.startswith(("#", "data:")) for link in reader.links)
    shown = re.sub(r'"data:[^"]*"', "", html)
    for loading in ("http:", "https:", "//", "url(", "@import", "srcset"):
        assert loading not in shown, loading


def test_findings_and_films_come_first_and_all_but_the_results_is_folded(written: Path) -> None:
    parts = Reader(written.read_text()).parts
    assert [name for name, is_open in parts if is_open] == ["findings", "films", "results"]
    assert [name for name, _ in parts[:3]] == ["findings", "films", "results"]
    folded = [name for name, is_open in parts if not is_open]
    assert {"failures", "paths", "commands", "scores", "accuracy", "made"} <= set(folded)
    assert len(set(folded)) == len(folded)


def test_the_answer_has_a_picture(written: Path) -> None:
    html = written.read_text()
    findings_part = html[html.index('<section id="findings">') : html.index('<section id="films">')]
    assert findings_part.count("<svg") == 1
    assert "Reached the goal" in findings_part


def test_no_film_is_empty(written: Path) -> None:
    media = Reader(written.read_text()).media
    assert len(media) == 1
    for one in media:
        assert (one["src"] or "").startswith("data:video/mp4;base64,")
        assert (one["poster"] or "").startswith("data:image/jpeg;base64,")


def test_without_videos_there_is_no_section_of_films(run: Path) -> None:
    html = page.make(open_run(run), 0, lambda _: None)
    assert [name for name, _ in Reader(html).parts[:2]] == ["findings", "results"]
    assert "<video" not in html


def test_the_title_says_what_is_compared_where_and_when(run: Path, tmp_path: Path) -> None:
    for name in ("manifest.json", "episodes.jsonl", "timing.jsonl"):
        shutil.copy(run / name, tmp_path)
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    (tmp_path / "manifest.json").write_text(json.dumps({**manifest, "begun": "2026-03-07"}))
    expected = "vpf against pid on open and barred — clear — seeds 3:5 — 7 Mar 2026"
    html = page.make(open_run(tmp_path), 0, lambda _: None)
    assert f"<title>{expected}</title>" in html
    assert f"<h1>{expected}</h1>" in html


@pytest.mark.parametrize(
    ("plan", "expected"),
    [
        (Plan(("town04",), ("rain",), ("vpf",), "7:8"), "vpf on town04 — rain — seed 7"),
        (Plan(("a.toml",), ("clear", "rain"), ("x", "y", "z"), "0:2"), "x, y and z on a — clear, rain — seeds 0:2"),
        (Plan(tuple("abcdef"), ("clear",), ("x",), "0:2"), "x on a, b, c and 3 others — clear — seeds 0:2"),
        (Plan(("a",), ("clear",), ("x",), "0:9", (("a", "clear", 1), ("a", "clear", 8))), "x on a — clear — 2 drives"),
    ],
)
def test_titles_name_a_few(plan: Plan, expected: str) -> None:
    assert headline.title(plan) == expected
    assert headline.title(plan, date(2026, 11, 26)) == f"{expected} — 26 Nov 2026"


def test_its_numbers_are_the_summarys(run: Path, written: Path) -> None:
    html = written.read_text()
    main = Reader(re.findall(r'<table class="main">.*?</table>', html, re.DOTALL)[0])
    expected = []
    order = Order(*(tuple(getattr(open_run(run).plan(), key)) for key in ("scenario", "weather", "driver")))
    for row in order.sorted(open_run(run).summary().rows):
        assert f"{row.successes} of {row.episodes}" in html
        for column in DRIVING:
            if (value := row[column]) is not None:
                words = f"{100.0 * value if column.percent else value:.{column.digits}f}"
                expected.append((value, words.replace("-", "−")))
    assert [exact for exact, _ in main.data] == [value for value, _ in expected]
    assert [words for _, words in main.data] == [words for _, words in expected]
    assert len(expected) > 10


def test_failures_are_listed_marked_and_have_clips(run: Path, written: Path) -> None:
    html = written.read_text()
    failed = [key for key, record in open_run(run).records.items() if not record.succeeded]
    assert 2 <= len(failed) < 8
    for name in failed:
        cell, _, seed = name.rpartition(".")
        file, weather, driver = cell.split(".")
        scenario = file.rpartition("-")[0]
        shown = rf'<th scope="row">{scenario}, {weather}, {driver}</th><td[^>]*>2 × collision with a barrier</td>'
        why = "[^<]+" if driver == "vpf" else "–"  # the PID shows no plan
        assert re.search(rf"{shown}<td[^>]*>{why}</td><td[^>]*>3, 4</td>", html), name
        assert seed in ("3", "4")
        assert f'title="{name}: collision with a barrier' in html
    (video,) = re.findall(r'<video [^>]*src="(data:video/mp4;base64,[^"]{1000,})"', html)
    assert len(video) < 3_000_000
    assert "Note:" not in html, "the clip equals the run, bit by bit"


def test_an_interrupted_run_is_reported_partially(run: Path, tmp_path: Path) -> None:
    for name in ("manifest.json", "timing.jsonl"):
        (tmp_path / name).write_bytes((run / name).read_bytes())
    first = (run / "episodes.jsonl").read_text().splitlines()[0]
    (tmp_path / "episodes.jsonl").write_text(f"{first}\n")
    html = page.make(open_run(tmp_path), 0, lambda _: None)
    assert "1 of 8 episodes" in html
    assert "1 not driven" in html
    assert "missing (7)" in html


def test_charts_of_a_changed_or_missing_scenario_are_left_out(run: Path, tmp_path: Path) -> None:
    manifest = json.loads((run / "manifest.json").read_text())
    opened, barred = manifest["plan"]["scenario"]
    gone = str(tmp_path / "gone.toml")
    text = {
        name: (run / name).read_text() for name in ("manifest.json", "episodes.jsonl", "summary.json", "timing.jsonl")
    }
    shutil.copytree(run / "steps", tmp_path / "steps")
    for name, content in text.items():
        (tmp_path / name).write_text(content.replace(opened, gone))
    plan = Plan((gone, barred), ("clear",), ("vpf", "pid"), "3:5")
    renamed = dict(zip(sorted(open_run(run).records), sorted(job.id for job in plan.jobs()), strict=True))
    for name, other in renamed.items():
        (tmp_path / "episodes.jsonl").write_text((tmp_path / "episodes.jsonl").read_text().replace(name, other))
        (tmp_path / "steps" / f"{name}.parquet").rename(tmp_path / "steps" / f"{other}.parquet")
    html = page.make(open_run(tmp_path), 0, lambda _: None)
    assert f"gone, clear: {gone}: " in html
    assert "<h3>barred, clear</h3>" in html
    manifest["scenarios"][barred] = "another"
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    (tmp_path / "episodes.jsonl").write_text(text["episodes.jsonl"])
    (tmp_path / "summary.json").write_text(text["summary.json"])
    html = page.make(open_run(tmp_path), 0, lambda _: None)
    assert "barred, clear: the scenario has changed since the run" in html
    assert "<dd>barred: changed since the run</dd>" in html


def test_files_that_are_no_run_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "empty").mkdir()
    for name, said in (
        ("gone", "expected a run folder, got nothing of that name"),
        ("file", "expected a run folder, got a file"),
        ("empty", "expected the manifest of a run, got: No such file or directory"),
    ):
        assert cli.run(["report", str(tmp_path / name)]) == 2
        error = capsys.readouterr().err
        assert error.startswith(f"vpf-sim: {tmp_path / name}")
        assert error.endswith(f"{said}\n")
        assert error.count("\n") == 1


def row(driver: str, scenario: str, successes: int, mse: float | None = None, **more: Any) -> Row:
    stored = {
        "scenario": scenario,
        "weather": "clear",
        "driver": driver,
        "privileged": "route" if driver == "pid" else "none",
        "successes": successes,
        "episodes": 5,
        "statuses": {"success": successes, "collision": 4 - successes} if successes < 4 else {"success": successes},
        "path_mse_m2": mse,
        "success_rate": successes / 5,
        "unsuccessful": {"path_mse_m2": 9.0},
        **more,
    }
    return read_summary({"rows": [stored]}, "a summary").rows[0]


def test_the_answer_has_successes_with_intervals_and_the_papers_mse() -> None:
    paper = {"path_mse_m2": 0.74, "throttle": 0.7851, "steering": 0.7167}
    rows = [
        row("pid", "town04", 0),
        row("pid", "town04-clean", 5, 0.003),
        row("vpf", "town04", 4, 0.4283, paper=paper),
        row("vpf", "town04-clean", 5, 0.001),
    ]
    jobs = [Job("town04", "clear", driver, seed) for seed in range(10) for driver in ORDER.drivers]
    records = {job.id: unscored(job, "success") for job in jobs if job.driver == "vpf" or job.seed < 4}
    against = headline.of_two(jobs, records, ORDER)
    assert against == paired_shares(np.ones(10, bool), np.arange(10) < 4)
    success, same_seeds, third = headline.sentences(rows, ORDER, against, "benchmark")
    low, high = (f"{100.0 * end:.0f}" for end in share_interval(9, 10))
    assert success.startswith(
        f"vpf reached the goal in 9 of 10 episodes (95 % interval: {low} to {high} %), pid in 5 of 10"
    )
    assert same_seeds.startswith("On the same seeds vpf reached it 60 percentage points more often than pid (")
    assert same_seeds.endswith("p = 0.031).")
    assert third.startswith("Path MSE of vpf, m²: 0.428 (clear, with obstacles; paper 0.74).")
    assert len(headline.sentences(rows, ORDER, against)) == 2, "the paper's is for its benchmark"


def test_the_answer_of_one_driver_says_where_it_failed() -> None:
    rows = [row("vpf", "town04", 4), row("vpf", "town04-clean", 5)]
    (only,) = headline.sentences(rows, Order(("town04-clean", "town04"), ("clear",), ("vpf",)), None)
    assert only.endswith(" %): 4 of 5 on town04 in clear, all in the others.")


def test_a_driver_without_success_has_no_figures_of_its_path() -> None:
    (group,) = main_table.groups([row("vpf", "town04", 0)], ORDER)
    (shown,) = group.rows
    assert (shown.successes, shown.endings) == (0, "4 collision, 1 not driven")
    assert [cell.text for cell in shown.cells[:3]] == ["–", "–", "–"]
    (shown,) = main_table.groups([row("vpf", "town04", 5, -0.0)], ORDER)[0].rows
    assert shown.cells[0].text == "0.000"


def test_intervals_are_read_from_the_summary() -> None:
    intervals = {"success_rate": [0.478, 1.0], "path_mse_m2": [-0.01, 0.5], "accuracy": None}
    (shown,) = main_table.groups([row("vpf", "town04", 5, 0.2, intervals=intervals)], ORDER)[0].rows
    assert shown.interval == "48 to 100"
    assert shown.cells[0].beside == "−0.010 to 0.500"
    assert shown.cells[1].beside == ""


def test_each_kind_of_failure_has_a_clip_before_any_has_two() -> None:
    def failed(driver: str, status: str, seed: int, scenario: str = "town04") -> Record:
        name = f"{scenario}.{driver}.{seed}"
        return Record(
            id=name, driver=driver, status=status, seed=seed, steps=9, scenario=scenario, weather="rain", scores={}
        )

    found = [
        failed("pid", "collision", 1),
        failed("pid", "collision", 2),
        failed("pid", "collision", 1, "slalom"),
        failed("vpf", "collision", 7),
        failed("vpf", "off_road", 9),
        failed("vpf", "error", 3).model_copy(update={"steps": 0}),
        failed("vpf", "success", 4),
    ]
    chosen = [record.id for record in clips.choose(found, ["vpf", "pid"], 4)]
    assert chosen == ["town04.vpf.7", "town04.vpf.9", "slalom.pid.1", "town04.pid.1"]
    assert len(clips.choose(found, ["vpf", "pid"], 9)) == 5
    assert clips.choose(found, ["vpf", "pid"], 0) == []
    good = [failed("pid", "success", 2), failed("vpf", "success", 4), failed("vpf", "success", 3)]
    assert [record.id for record in clips.choose(good, ["vpf", "pid"], 4)] == ["town04.vpf.3"], "one if all succeed"


@pytest.mark.skipif(chromium.program() is None, reason="no chromium on this machine")
def test_a_browser_shows_the_page_without_requests(written: Path, tmp_path: Path) -> None:
    play = """Promise.all([...document.querySelectorAll("video")].map(async (video) => {
        await video.play();
        for (let i = 0; i < 100 && (video.readyState < 2 || video.currentTime === 0); i++)
            await new Promise((done) => setTimeout(done, 100));
        return [video.readyState, video.duration, video.currentTime > 0];
    }))"""
    unfolded = """(() => {
        document.querySelectorAll("details").forEach((part) => { part.open = true; });
        return document.documentElement.scrollHeight;
    })()"""
    overlaps = """[...document.querySelectorAll("svg")].flatMap((chart) => {
        const labels = [...chart.querySelectorAll("text:not(.cross)")].map((label) => label.getBoundingClientRect());
        const outer = chart.getBoundingClientRect();
        const beside = (a, b) => a.right < b.left + 1 || b.right < a.left + 1;
        const above = (a, b) => a.bottom < b.top + 4 || b.bottom < a.top + 4;
        const apart = (a, b) => beside(a, b) || above(a, b);
        const inside = (a) => a.left > outer.left - 1 && a.right < outer.right + 1;
        const bad = labels.some((a, i) => !inside(a) || labels.slice(0, i).some((b) => !apart(a, b)));
        return bad ? [chart.getAttribute("aria-label")] : [];
    })"""
    with chromium.browser(tmp_path / "profile") as tab:
        for width in (1280, 390):
            tab.open(written, width)
            assert tab.ask("document.documentElement.scrollWidth") == width, "nothing sticks out"
            assert tab.ask("document.documentElement.scrollHeight") < tab.ask(unfolded) / 2, "most of it is folded"
            assert tab.ask(overlaps) == []
            (video,) = tab.ask(play)
            assert video[0] >= 2
            assert video[1] == pytest.approx(clip_length_s(written), abs=0.1)
            assert video[2]
        light, dark = (picture_level(tab, written, scheme) for scheme in (False, True))
        assert light > 200.0 > 100.0 > dark
        assert tab.paper().startswith(b"%PDF")
    assert set(tab.requested) == {written.as_uri()}
    assert tab.errors == []


def clip_length_s(written: Path) -> float:
    """Of the filmed episode: shorter than a clip may be."""
    (name,) = re.findall(r"--id ([\w.-]+)</code>", written.read_text())
    table = open_run(written.parent).steps(name)
    assert table is not None
    return float(table.time_s[-1])


def picture_level(tab: chromium.Browser, written: Path, dark: bool) -> float:
    """The mean brightness of the page."""
    import cv2

    tab.open(written, 1280, dark)
    image = cv2.imdecode(np.frombuffer(tab.picture(), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert image is not None
    return float(np.median(image))
