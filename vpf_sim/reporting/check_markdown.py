"""Writes the gate's checks as Markdown, for the summary of a CI job."""

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from vpf_sim.evaluation.gate.checks import Check, listed, repeats, unlisted
from vpf_sim.files import write_text
from vpf_sim.reporting.kit.table import Table

WORDS = {"passed": "✅ ok", "failed": "❌ fail", "skipped": "– skipped"}


def write_markdown(checks: Sequence[Check], path: Path) -> None:
    """Write the verdict, the failed checks with the commands that repeat them, and a table of the listed ones."""
    shown = listed(checks)
    failed = [one for one in shown if one.outcome == "failed"]
    counts: Counter[str] = Counter(one.outcome for one in checks)
    verdict = f"❌ Gate: {len(failed)} of {len(shown)} checks failed" if failed else "✅ Gate: all checks passed"
    lines = [f"## {verdict}", "", ", ".join(f"{counts[outcome]} {outcome}" for outcome in WORDS) + "."]
    if failed:
        lines += ["", *_table(failed)]
    if commands := repeats(one for one in checks if one.outcome == "failed"):
        lines += ["", "Drive the failures again, the worst seeds first:", "", "```sh", *commands, "```"]
    lines += ["", "<details><summary>All checks</summary>", "", *_table(shown)]
    if said := unlisted(checks):
        lines += ["", f"{said[0].upper()}{said[1:]}."]
    lines += ["", "</details>"]
    write_text(path, "\n".join([*lines, ""]))


def _table(checks: Iterable[Check]) -> list[str]:
    rows = [(WORDS[one.outcome], *one.cell, one.expected, one.actual) for one in checks]
    header = ("", "scenario", "weather", "driver", "expected", "actual")
    return [*Table(header, tuple(tuple(map(_text, row)) for row in rows), words=len(header)).markdown()]


def _text(text: str) -> str:
    """A text in one line of a table's cell, without meaning in Markdown or HTML."""
    plain = "".join(char if char.isprintable() else "?" for char in text)
    for char in "\\`*_[]~":
        plain = plain.replace(char, f"\\{char}")
    return plain.replace("&", "&amp;").replace("<", "&lt;")
