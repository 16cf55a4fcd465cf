"""Hashes of the inputs of a replayed drive, to decide whether a folder can be resumed."""

from collections.abc import Iterable, Mapping
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any

from vpf_sim.drivers import MODEL_PREFIX, VARIANT_PREFIX
from vpf_sim.evaluation.sweeps.fingerprint import own_code
from vpf_sim.replay import image_files
from vpf_sim.replay.recording import SIGNALS, Recording

Hashes = dict[str, dict[str, str]]
HASHED = ("weathers", "drivers")  # by name


def hashes(recordings: Mapping[str, Recording], driver: str, water: str | None) -> dict[str, dict[str, Any]]:
    """Hashes of the recordings by name, of the water's weather, and of a driver's own code."""
    from vpf_sim.envs.camera import weather

    code = own_code(driver)
    return {
        "recordings": {name: of_recording(recording) for name, recording in recordings.items()},
        "weathers": {} if water is None else {water: _hash(repr(weather.load(water)).encode())},
        "drivers": {} if code is None else {driver: code},
    }


def without_folders(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """A manifest in which files have no folders: the hashes of their content tell them apart, wherever they are.

    The folders depend on the working folder from which a replay is started.
    """
    plan = dict(_table(manifest, "plan"))
    plan |= {key: _last(name) for key in ("driver", "water") if isinstance(name := plan.get(key), str)}
    tables = {key: {_last(name): value for name, value in _table(manifest, key).items()} for key in HASHED}
    return {**manifest, **tables, "plan": {**plan, "drives": sorted(_table(plan, "drives"))}}


def _table(table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """A table within a table; an empty one where there is none."""
    found = table.get(key)
    return found if isinstance(found, Mapping) else {}


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


def changed(before: Mapping[str, Any], after: Mapping[str, Any], kinds: Iterable[str]) -> str:
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
