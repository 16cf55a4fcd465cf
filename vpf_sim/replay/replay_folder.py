"""A replay's folder: manifest, records, timing, frame tables, videos and summary."""

import json
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint
from vpf_sim.evaluation.sweeps.manifest import change
from vpf_sim.evaluation.sweeps.run_folder import LOCK, JsonLines, check_name, locked, read_lines, write_json
from vpf_sim.replay import inputs
from vpf_sim.replay.real_table import DIFFERENCES, rows

MANIFEST, RECORDS, TIMING, SUMMARY = "manifest.json", "replays.jsonl", "timing.jsonl", "summary.json"


class ReplayFolder:
    """An open folder; `done` holds the names of the drives with a record."""

    def __init__(
        self,
        path: Path,
        asked_for: dict[str, Any],
        resume: bool = False,
        mixed: bool = False,
    ):
        """Create the folder, or continue with `resume`.

        `asked_for` is the plan and the hashes of its inputs (`inputs.hashes`).
        """
        self.path = path
        self._digest: str | None = None  # the fingerprint's digest, if it differs from the manifest's
        requested = {
            "schema": 1,
            "command": "replay",
            "fingerprint": fingerprint(),
            **asked_for,
        }
        new = not resume or not (path / MANIFEST).exists()
        if new:
            self._check_new()
            path.mkdir(parents=True, exist_ok=True)
        elif self._continue(requested, mixed):
            self._digest = digest(requested["fingerprint"])
        with ExitStack() as opened:
            self._lock = locked(path)
            opened.callback(self._lock.release)
            if new:
                self._check_new()  # another replay may have begun in it until now
            self._records = opened.enter_context(closing(JsonLines(path / RECORDS)))
            self._timing = opened.enter_context(closing(JsonLines(path / TIMING)))
            if new:
                self._write_json(MANIFEST, requested)
            self.done = {record["name"] for record in self.records()}
            opened.pop_all()

    def add(self, record: dict[str, Any], timing: dict[str, Any]) -> None:
        """Store a finished drive, unless it has a record already."""
        if record["name"] in self.done:
            return
        self._timing.append(timing)
        self._records.append({**record, "fingerprint": self._digest} if self._digest else record)
        self.done.add(record["name"])

    def records(self) -> list[dict[str, Any]]:
        """All records, ordered by name."""
        return sorted(read_lines(self.path / RECORDS), key=lambda record: str(record["name"]))

    def timing(self) -> dict[str, dict[str, Any]]:
        """Timing by name of the drive."""
        return {str(line["name"]): line for line in read_lines(self.path / TIMING)}

    def summarize(self) -> dict[str, Any]:
        """Write and return the summary, a function of the records."""
        summary = {"rows": rows(self.records()), "differences": list(DIFFERENCES)}
        self._write_json(SUMMARY, summary)
        return summary

    def close(self) -> None:
        self._records.close()
        self._timing.close()
        self._lock.release()

    def _check_new(self) -> None:
        check_name(self.path)
        if self.path.exists() and not self.path.is_dir():
            raise InputError(f"{self.path}: expected a folder, got a file")
        if self.path.exists() and any(file.name != LOCK for file in self.path.iterdir()):
            remedy = (
                "choose another, or --resume what is there" if (self.path / MANIFEST).exists() else "got other files"
            )
            raise InputError(f"{self.path}: expected an empty or new folder for --out, {remedy}")

    def _continue(self, requested: dict[str, Any], mixed: bool) -> bool:
        """Check that the plan is the same; True if the fingerprint differs, which needs `mixed`."""
        try:
            stored = json.loads((self.path / MANIFEST).read_bytes())
        except ValueError:
            stored = None
        if not isinstance(stored, dict):
            raise InputError(f"{self.path / MANIFEST}: expected a JSON object, got something else")
        same_code = stored.get("fingerprint") == requested["fingerprint"]
        before, after = (inputs.without_folders(one) for one in (stored, requested))
        for key in ("command", "plan", "weathers", "drivers"):
            if before.get(key) != after.get(key):
                what = change(before.get(key), after.get(key))
                raise InputError(f"{self.path}: --resume: {key} changed: {what}; start a new run")
        for name, recording in requested["recordings"].items():
            kinds = ("read", "derived") if same_code else ("read",)  # other code may derive other values
            earlier = stored.get("recordings", {}).get(name, {})
            if what := inputs.changed(earlier, recording, kinds):
                raise InputError(f"{self.path}: --resume: the drive '{name}' changed: {what}; start a new run")
        if same_code:
            return False
        if not mixed:
            what = change(stored.get("fingerprint"), requested["fingerprint"])
            raise InputError(f"{self.path}: --resume: fingerprint changed: {what}; --mixed accepts it")
        return True

    def _write_json(self, name: str, value: dict[str, Any]) -> None:
        """Complete or not at all, keys sorted."""
        write_json(self.path / name, value)
