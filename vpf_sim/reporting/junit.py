"""Writes the gate's checks as JUnit XML, which GitLab and several GitHub actions read.

One test case per rule and cell. The elements and attributes are those of Jenkins' schema, which the readers share:
https://github.com/jenkinsci/xunit-plugin/blob/master/src/main/resources/org/jenkinsci/plugins/xunit/types/model/xsd/junit-10.xsd
"""

import re
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as Xml

from vpf_sim.evaluation.gate.checks import Check
from vpf_sim.files import write_bytes

SUITE = "vpf-sim check"
FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # invalid in XML 1.0, even escaped


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
