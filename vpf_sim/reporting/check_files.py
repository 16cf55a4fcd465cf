"""The gate's checks as files for CI: JUnit XML, and Markdown for a job's summary."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.etree import ElementTree as Xml

from vpf_sim.evaluation.gate.checks import Check, listed, repeats, unlisted
from vpf_sim.files import write_bytes, write_text
from vpf_sim.reporting.kit.page import Table

SUITE = "vpf-sim check"
FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # invalid in XML 1.0, even escaped
WORDS = {"passed": "✅ ok", "failed": "❌ fail", "skipped": "– skipped"}


def write_junit(checks: Sequence[Check], path: Path) -> None:
    """Write the file, without times, so that the same run gives the same bytes."""
    counts = {"tests": len(checks), "failures": _count(checks, "failed"), "errors": 0}
    totals = {"name": SUITE, **{key: str(count) for key, count in counts.items()}}
    root = Xml.Element("testsuites", totals)
    suite = Xml.SubElement(root, "testsuite", {**totals, "skipped": str(_count(checks, "skipped"))})
    for check in checks:
        _add(suite, check)
    Xml.indent(root)
    write_bytes(path, Xml.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")


def _add(suite: Xml.Element, check: Check) -> None:
    case = Xml.SubElement(suite, "testcase", {"classname": _text(".".join(check.cell)), "name": _text(check.expected)})
    if check.outcome == "skipped":
        Xml.SubElement(case, "skipped", {"message": _text(check.actual)})
    if check.outcome == "failed":
        message = f"expected {check.expected}, got {check.actual}"
        failure = Xml.SubElement(case, "failure", {"message": _text(message), "type": "rule"})
        again = f"\nagain: {check.rerun}" if check.rerun else ""
        failure.text = _text(f"{message}\n{', '.join(check.cell)}{again}")


def _count(checks: Sequence[Check], outcome: str) -> int:
    return sum(check.outcome == outcome for check in checks)


def _text(text: str) -> str:
    return FORBIDDEN.sub("?", text)


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
    return [*Table(header, tuple(tuple(map(_markdown_text, row)) for row in rows), words=len(header)).markdown()]


def _markdown_text(text: str) -> str:
    """A text in one line of a table's cell, without meaning in Markdown or HTML."""
    plain = "".join(char if char.isprintable() else "?" for char in text)
    for char in "\\`*_[]~":
        plain = plain.replace(char, f"\\{char}")
    return plain.replace("&", "&amp;").replace("<", "&lt;")
