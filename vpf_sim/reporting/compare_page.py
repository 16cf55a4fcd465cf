"""The page that compares two runs: the findings, what changed in pictures, and every score with its interval."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from vpf_sim.evaluation.analysis.statistics import share_interval
from vpf_sim.evaluation.metrics.registry import SUCCESS
from vpf_sim.evaluation.sweeps.manifest import change
from vpf_sim.reporting import changes, endings, headline, video
from vpf_sim.reporting.kit import interval_chart
from vpf_sim.reporting.kit.interval_chart import Dot
from vpf_sim.reporting.kit.page import NONE, Line, Table, Value, formatted, interval_text, render
from vpf_sim.reporting.main_table import shown
from vpf_sim.reporting.two_runs import AGAINST, SCORES, Cell, Compared, Pair, TwoRuns, compared

ORDER = ("worse", "better", "undecided", "same")  # of scores
MOST_DRAWN = 8  # cells of the picture


def make(runs: TwoRuns, count: int, notify: Callable[[str], None]) -> str:
    """The page as HTML, with pictures of up to `count` episodes; `notify` receives progress messages."""
    overall, cells = compared(runs.pairs), runs.cells()
    chosen = changes.choose(runs.pairs, count)
    video.can_film(len(chosen), notify)
    return render(
        "compare.html.jinja",
        title=title(runs),
        labels=runs.labels,
        styles=changes.STYLES,
        findings=sentences(runs, overall),
        picture=_picture(runs, cells),
        changes=[changes.make(runs, pair, notify) for pair in chosen],
        any_changed=any(pair.changed for pair in runs.pairs),
        endings=_endings(runs),
        scores=_table([((), overall)], ()),
        by_cell=_table([(cell, compared(pairs)) for cell, pairs in cells.items()], ("scenario", "weather", "driver")),
        cell_count=len(cells),
        made=[*_made(runs)],
    )


def title(runs: TwoRuns) -> str:
    """What is compared, where, on which seeds, and when; a renamed driver or weather is named once, at the front."""
    columns = zip(*runs.cells(), strict=True)
    scenarios, weathers, drivers = (
        headline.listed([name for name in dict.fromkeys(column) if AGAINST not in name]) for column in columns
    )
    days = dict.fromkeys(headline.day(begun) for one in (runs.b, runs.a) if (begun := one.run.begun))
    seeds = endings.ranges(sorted({pair.jobs[0].seed for pair in runs.pairs}))
    what = f"{runs.labels[1]} against {runs.labels[0]}{f': {drivers}' if drivers else ''} on {scenarios}"
    return " — ".join(filter(None, (what, weathers, f"seeds {seeds}", " against ".join(days))))


def sentences(runs: TwoRuns, overall: dict[str, Compared]) -> list[str]:
    """Success with its interval, the episodes that changed, and the scores that got better or worse."""
    (a, b), success = runs.labels, overall[SUCCESS.key].difference
    reached = [sum(pair.records[which].succeeded for pair in runs.pairs) for which in (0, 1)]
    of = len(runs.pairs)
    found = [
        f"{b} reached the goal in {reached[1]} of {of} episodes, {a} in {reached[0]}: "
        f"{headline.difference(success, a)}{_decided(overall[SUCCESS.key])}."
    ]
    changed = [pair for pair in runs.pairs if pair.changed]
    fixed = sum(pair.records[1].succeeded for pair in changed)
    if changed:
        found.append(f"Of {of} episodes {fixed} now reach the goal, {len(changed) - fixed} no longer do.")
    others = {verdict: [*_named(overall, verdict)] for verdict in ("better", "worse")}
    words = [f"{verdict.capitalize()}: {', '.join(names)}." for verdict, names in others.items() if names]
    return [*found, " ".join(words) or "No other score is better or worse beyond chance."]


def _decided(found: Compared) -> str:
    return "" if found.verdict in ("better", "worse") else "; the interval includes no difference"


def _named(overall: dict[str, Compared], verdict: str) -> Iterator[str]:
    """Scores with a verdict, with the difference and its interval."""
    for key, one in overall.items():
        if key != SUCCESS.key and one.verdict == verdict:
            metric, found = SCORES[key], one.difference
            values = _signed(found.difference, metric.digits, metric.percent)
            ends = interval_text(found.interval, metric.digits, metric.percent)
            yield f"{metric.title} {values}{f' {metric.unit}' if metric.unit else ''} ({ends})"


def _picture(runs: TwoRuns, cells: dict[Cell, list[Pair]]) -> Any:
    """The share of episodes that reached the goal in both runs, by cell or over all."""
    parts = [(", ".join(shown(name) for name in cell if AGAINST not in name), pairs) for cell, pairs in cells.items()]
    if len(parts) > MOST_DRAWN:
        parts = [("all", list(runs.pairs))]
    dots = []
    for name, pairs in parts:
        for which, label in enumerate(runs.labels):
            count = sum(pair.records[which].succeeded for pair in pairs)
            low, high = share_interval(count, len(pairs))
            ends = (100.0 * low, 100.0 * high)
            dots.append(Dot(name, label, 0, changes.STYLES[which], 100.0 * count / len(pairs), ends))
    return interval_chart.chart(dots, [], "Episodes that reached the goal, %", (0.0, 100.0))


def _table(rows: Sequence[tuple[tuple[str, ...], dict[str, Compared]]], names: tuple[str, ...]) -> Table:
    """The scores, what got worse first."""
    lines: list[Line] = []
    for cell, found in rows:
        for key, one in sorted(found.items(), key=lambda item: ORDER.index(item[1].verdict)):
            metric, difference = SCORES[key], one.difference
            number = (metric.digits, metric.percent)
            ends = interval_text(difference.interval, *number) or NONE
            lines.append(
                (
                    *map(shown, cell),
                    metric.heading,
                    one.verdict,
                    *(Value(formatted(value, *number), value=value) for value in (one.a, one.b)),
                    Value(_signed(difference.difference, *number), value=difference.difference),
                    *(ends, headline.probability(difference.p).removeprefix("= "), str(difference.pairs)),
                )
            )
    header = (*names, "score", "verdict", "A", "B", "B − A", "95 % interval", "p", "pairs")
    return Table(header, tuple(lines), len(names) + 2)


def _signed(value: float, digits: int, percent: bool) -> str:
    text = formatted(value, digits, percent)
    return f"+{text}" if value > 0.0 and float(text) > 0.0 else text


def _endings(runs: TwoRuns) -> Table:
    """Name and both endings of each episode with another ending, those that now fail first."""
    pairs = changes.choose(runs.pairs, len(runs.pairs)) if any(pair.changed for pair in runs.pairs) else []
    rows = tuple((changes.name(pair), pair.records[0].ending, pair.records[1].ending) for pair in pairs)
    return Table(("episode", f"A, {runs.labels[0]}", f"B, {runs.labels[1]}"), rows, words=3)


def _made(runs: TwoRuns) -> Iterator[tuple[str, str]]:
    """Both folders, what differs between their versions, and what was not compared."""
    for letter, one in zip("AB", (runs.a, runs.b), strict=True):
        yield letter, f"{one.run.path}: {headline.title(one.plan, one.run.begun)}"
    a, b = (one.run.manifest.fingerprint for one in (runs.a, runs.b))
    yield "versions", change(a, b) if a != b else "the same"
    yield "without a partner", "{} episodes of A, {} of B".format(*runs.left_out)
    if runs.changed_worlds:
        yield "left out", f"of another content in A and B: {', '.join(runs.changed_worlds)}"
