"""The folder of a replay: manifest, a record and a timing line a drive, tables of frames, films, and the summary."""

import json
from pathlib import Path
from typing import Any

from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint
from vpf_sim.evaluation.sweeps.json_lines import JsonLines, read_lines
from vpf_sim.evaluation.sweeps.run_folder import change, write_json
from vpf_sim.replay import inputs
from vpf_sim.replay.real_table import DIFFERENCES, rows

MANIFEST, RECORDS, TIMING, SUMMARY = "manifest.json", "replays.jsonl", "timing.jsonl", "summary.json"


class ReplayFolder:
    """An open folder. `done` holds the names of the drives that it has a record of."""

    def __init__(
        self,
        path: Path,
        asked_for: dict[str, Any],
        resume: bool = False,
        mixed: bool = False,
    ):
        """`asked_for` is the plan, and the hashes of what it is made from (`inputs.hashes`); with `resume` it goes on
        with what is there."""
        self.path = path
        self._mark: str | None = None  # the fingerprint's digest, where records are made on another than the manifest's
        asked = {
            "schema": 1,
            "command": "replay",
            "fingerprint": fingerprint(),
            **asked_for,
        }
        new = not resume or not (path / MANIFEST).exists()
        if new:
            self._make()
        elif self._continue(asked, mixed):
            self._mark = digest(asked["fingerprint"])
        self._records = JsonLines(path / RECORDS)  # from here on the folder is locked
        self._timing = JsonLines(path / TIMING)
        if new:
            self._write_json(MANIFEST, asked)
        self.done = {record["name"] for record in self.records()}

    def add(self, record: dict[str, Any], timing: dict[str, Any]) -> None:
        """Store a finished drive; one that was driven again, for its film, has its record already."""
        if record["name"] in self.done:
            return
        self._timing.append(timing)
        self._records.append({**record, "fingerprint": self._mark} if self._mark else record)
        self.done.add(record["name"])

    def records(self) -> list[dict[str, Any]]:
        """All records, in the order of their names."""
        return sorted(read_lines(self.path / RECORDS), key=lambda record: str(record["name"]))

    def timing(self) -> dict[str, dict[str, Any]]:
        """What a clock measured, by the names of the drives."""
        return {str(line["name"]): line for line in read_lines(self.path / TIMING)}

    def summarize(self) -> dict[str, Any]:
        """Write and give the summary: a function of the records."""
        summary = {"rows": rows(self.records()), "differences": list(DIFFERENCES)}
        self._write_json(SUMMARY, summary)
        return summary

    def close(self) -> None:
        self._records.close()
        self._timing.close()

    def _make(self) -> None:
        if self.path.exists() and not self.path.is_dir():
            raise InputError(f"{self.path}: expected a folder, got a file")
        if self.path.exists() and any(self.path.iterdir()):
            remedy = (
                "choose another, or --resume what is there" if (self.path / MANIFEST).exists() else "got other files"
            )
            raise InputError(f"{self.path}: expected an empty or new folder for --out, {remedy}")
        self.path.mkdir(parents=True, exist_ok=True)

    def _continue(self, asked: dict[str, Any], mixed: bool) -> bool:
        """Check that the same is asked; whether the fingerprint is another, which only `mixed` allows."""
        try:
            stored = json.loads((self.path / MANIFEST).read_text("utf-8"))
        except ValueError:
            raise InputError(f"{self.path / MANIFEST}: expected JSON, got something else") from None
        same_code = stored.get("fingerprint") == asked["fingerprint"]
        for key in ("command", "plan", "weathers", "drivers"):
            if stored.get(key) != asked[key]:
                what = change(stored.get(key), asked[key])
                raise InputError(f"{self.path}: --resume: {key} changed: {what}; start a new run")
        for name, recording in asked["recordings"].items():
            kinds = ("read", "derived") if same_code else ("read",)  # other code may derive other bits
            before = stored.get("recordings", {}).get(name, {})
            if what := inputs.changed(before, recording, kinds):
                raise InputError(f"{self.path}: --resume: the drive '{name}' changed: {what}; start a new run")
        if same_code:
            return False
        if not mixed:
            what = change(stored.get("fingerprint"), asked["fingerprint"])
            raise InputError(f"{self.path}: --resume: fingerprint changed: {what}; --mixed accepts it")
        return True

    def _write_json(self, name: str, value: dict[str, Any]) -> None:
        """Whole or not at all, keys sorted."""
        write_json(self.path / name, value)
