"""Run folders that are torn or foreign: each command that reads one refuses it in a clear line and changes nothing."""

import json
from pathlib import Path
from typing import Any

import pytest
from malformed import RULES
from systems import at_most

from vpf_sim import cli

LONGEST_S = 30
LONGEST_LINE = 1000
MANIFEST: dict[str, Any] = {
    "schema": 1,
    "command": "sweep",
    "plan": {"scenario": ["straight"], "weather": ["clear"], "driver": ["vpf"], "seeds": "0:3"},
    "fingerprint": {},
    "scenarios": {"straight": "abc"},
    "weathers": {"clear": "def"},
}
TEXT = json.dumps(MANIFEST)
PLANS = [{**MANIFEST["plan"], key: wrong} for key in MANIFEST["plan"] for wrong in (7, None, {}, [[]])]
MANIFESTS = {
    "torn": TEXT[:90],
    "a list": "[]",
    "foreign": "\\documentclass{article}\n",
    "deep": "[" * 100_000,
    **{f"without {gone}": json.dumps({**MANIFEST, gone: None}) for gone in ("plan", "fingerprint", "scenarios")},
    **{f"plan {k}": json.dumps({**MANIFEST, "plan": plan}) for k, plan in enumerate(PLANS)},
}
LINES = [b'{"id": "a"', b"[1]", b"\xff\xff", b'{"seed": 1}', b"[" * 100_000, b'{"id": 5, "a": NaN}']
SPOILT = [*((text, b"", name) for name, text in MANIFESTS.items()), *((TEXT, line, "") for line in LINES)]
COMMANDS = ["sweep --out RUN --resume", "sweep --out RUN", "check RUN --rules rules.toml", "score RUN", "report RUN"]


@pytest.mark.parametrize(("manifest", "line", "name"), SPOILT)
def test_a_torn_or_foreign_run_folder_is_refused_and_left_alone(
    manifest: str, line: bytes, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rules.toml").write_text(RULES)
    files = {"manifest.json": manifest.encode(), "episodes.jsonl": line and line + b'\n{"id": "b"}\n'}
    (tmp_path / "run").mkdir()
    for file, content in files.items():
        (tmp_path / "run" / file).write_bytes(content)
    for command in [*COMMANDS, "video RUN --id a"]:
        with at_most(LONGEST_S):
            assert cli.run(command.replace("RUN", "run").split()) == 2, (command, name)
        said = capsys.readouterr()
        assert said.out == ""
        assert 1 <= len(said.err.splitlines()) <= 12
        assert all(one.startswith("vpf-sim: ") and len(one) < LONGEST_LINE for one in said.err.splitlines()), said.err
        assert "run" in said.err.removeprefix("vpf-sim: ")
    assert {file: (tmp_path / "run" / file).read_bytes() for file in files} == files, "nothing of the user's is touched"
