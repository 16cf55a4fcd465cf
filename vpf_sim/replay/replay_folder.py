"""A replay's folder: manifest, records, timing, frame tables, videos and summary.

The manifest has hashes of what was read and of what was derived from it, to decide whether the folder can be resumed.
"""

from collections.abc import Iterable, Sequence
from contextlib import ExitStack, closing
from hashlib import file_digest, sha256
from pathlib import Path

from vpf_sim.drivers import MODEL_PREFIX, VARIANT_PREFIX
from vpf_sim.errors import InputError
from vpf_sim.evaluation.metrics.records import checked
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint, own_code
from vpf_sim.evaluation.sweeps.manifest import change
from vpf_sim.evaluation.sweeps.run_folder import LOCK, JsonLines, check_name, locked, write_json
from vpf_sim.files import read_object
from vpf_sim.replay import image_files, real_table, records
from vpf_sim.replay.recording import SIGNALS, Recording
from vpf_sim.replay.records import DriveRecord, Hashes, ReplayManifest, ReplayPlan, Summary, Timing

MANIFEST, RECORDS, TIMING, SUMMARY = "manifest.json", "replays.jsonl", "timing.jsonl", "summary.json"


class ReplayFolder:
    """An open folder; `done` holds the names of the drives with a record."""

    def __init__(self, path: Path, requested: ReplayManifest, resume: bool = False, mixed: bool = False):
        """Create the folder, or continue with `resume`."""
        self.path = path
        self._digest: str | None = None  # the fingerprint's digest, if it differs from the manifest's
        new = not resume or not (path / MANIFEST).exists()
        if new:
            self._check_new()
            path.mkdir(parents=True, exist_ok=True)
        elif self._continue(requested, mixed):
            self._digest = digest(requested.fingerprint)
        with ExitStack() as opened:
            self._lock = locked(path)
            opened.callback(self._lock.release)
            if new:
                self._check_new()  # another replay may have begun in it until now
            self._records = opened.enter_context(closing(JsonLines(path / RECORDS)))
            self._timing = opened.enter_context(closing(JsonLines(path / TIMING)))
            if new:
                write_json(path / MANIFEST, requested.as_json())
            self.done = {record.name for record in self.records()}
            opened.pop_all()

    def add(self, record: DriveRecord, timing: Timing) -> None:
        """Store a finished drive, unless it has a record already."""
        if record.name in self.done:
            return
        self._timing.append(timing.model_dump())
        self._records.append(record.model_copy(update={"fingerprint": self._digest}).as_json())
        self.done.add(record.name)

    def records(self) -> list[DriveRecord]:
        """All records, ordered by name."""
        return records.read(DriveRecord, self.path / RECORDS)

    def timing(self) -> dict[str, Timing]:
        """Timing by name of the drive."""
        return {line.name: line for line in records.read(Timing, self.path / TIMING)}

    def summarize(self) -> Summary:
        """Write and return the summary, a function of the records."""
        summary = real_table.summary(self.records())
        write_json(self.path / SUMMARY, summary.model_dump())
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

    def _continue(self, requested: ReplayManifest, mixed: bool) -> bool:
        """Check that the plan is the same; True if the fingerprint differs, which needs `mixed`."""
        stored, where = self._stored(), f"{self.path}: --resume"
        before, after = (_without_folders(one) for one in (stored, requested))
        for key, value in after.items():
            if before[key] != value:
                raise InputError(f"{where}: {key} changed: {change(before[key], value)}; start a new run")
        same_code = stored.fingerprint == requested.fingerprint
        kinds = ("read", "derived") if same_code else ("read",)  # other code may derive other values
        for name, recording in requested.recordings.items():
            if what := changed(stored.recordings.get(name, {}), recording, kinds):
                raise InputError(f"{where}: the drive '{name}' changed: {what}; start a new run")
        if not same_code and not mixed:
            what = change(stored.fingerprint, requested.fingerprint)
            raise InputError(f"{where}: fingerprint changed: {what}; --mixed accepts it")
        return not same_code

    def _stored(self) -> ReplayManifest:
        stored = read_object(self.path / MANIFEST)
        if (command := stored.get("command")) != "replay":
            what = change(command, "replay")
            raise InputError(f"{self.path}: --resume: command changed: {what}; start a new run")
        return checked(ReplayManifest, stored, str(self.path / MANIFEST))


def manifest(plan: ReplayPlan, recordings: Sequence[Recording]) -> ReplayManifest:
    """The manifest of a replay: hashes of the recordings, of the water's weather, and of a driver's own code."""
    from vpf_sim.envs.camera import weather

    code = own_code(plan.driver)
    return ReplayManifest(
        fingerprint=fingerprint(),
        plan=plan,
        recordings={recording.name: of_recording(recording) for recording in recordings},
        weathers={} if plan.water is None else {plan.water: _hash(repr(weather.load(plan.water)).encode())},
        drivers={} if code is None else {plan.driver: code},
    )


def _without_folders(manifest: ReplayManifest) -> Json:
    """Plan and hashes in which files have no folders: the hashes tell them apart, wherever they are.

    The folders depend on the working folder from which a replay is started.
    """
    plan = manifest.plan
    weathers, drivers = ({_last(name): one for name, one in of.items()} for of in (manifest.weathers, manifest.drivers))
    named: Json = {"driver": _last(plan.driver), "water": plan.water and _last(plan.water), "faults": plan.faults}
    return {"plan": {**named, "drives": sorted(plan.drives)}, "weathers": weathers, "drivers": drivers}


def _last(name: str) -> str:
    """The name of a driver or weather; of a file without its folder, after the prefix: "vpf@own.toml"."""
    if not name.endswith((".toml", ".onnx")):
        return name
    prefix = next((one for one in (VARIANT_PREFIX, MODEL_PREFIX) if name.startswith(one)), "")
    return prefix + Path(name.removeprefix(prefix)).name


def of_recording(recording: Recording) -> Hashes:
    """Hashes of what was `read` (files and their signals) and of what was `derived` from it."""
    signals = {name: _signal(recording, name) for name in SIGNALS if name != "camera"}
    derived = {name for name in signals if recording.origins[name].kind != "recorded"}
    read = {name: value for name, value in signals.items() if name not in derived}
    return {
        "read": {**_files(recording.files), **read, "weather": _hash(recording.weather.encode("utf-8", "replace"))},
        "derived": {**{name: signals[name] for name in derived}, "camera": _hash(repr(recording.camera).encode())},
    }


def changed(before: Hashes, after: Hashes, kinds: Iterable[str]) -> str:
    """Names of what differs, as "drive.mp4, speed_mps"; empty if nothing does."""
    names = []
    for kind in kinds:
        old, new = before.get(kind, {}), after.get(kind, {})
        names += [name for name in new.keys() | old.keys() if old.get(name) != new.get(name)]
    return ", ".join(sorted(names))


def _signal(recording: Recording, name: str) -> str:
    return _hash(getattr(recording, name).astype("<f8").tobytes())


def _files(files: Iterable[Path | None]) -> dict[str, str]:
    """Hash of each file by name, and one of all images together."""
    found: dict[str, str] = {}
    images = sha256()
    for path in files:
        if path is None or not path.is_file():
            continue
        content = _of_file(path)
        if path.suffix.lower() in image_files.SUFFIXES:
            images.update(f"{path.name} {content}\n".encode("utf-8", "surrogateescape"))
            found["images"] = images.hexdigest()
        else:
            found[path.name] = content
    return found


def _of_file(path: Path) -> str:
    with path.open("rb") as stream:
        return file_digest(stream, "sha256").hexdigest()


def _hash(content: bytes) -> str:
    return sha256(content).hexdigest()
