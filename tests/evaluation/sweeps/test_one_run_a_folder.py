"""A run folder has one run at a time, from its first file to its last."""

import json
import shutil
from pathlib import Path
from typing import Any

import filelock
import pytest

from vpf_sim import system
from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps import run_folder
from vpf_sim.evaluation.sweeps.manifest import Manifest
from vpf_sim.evaluation.sweeps.run_folder import MANIFEST, RunFolder, located
from vpf_sim.replay import replay_folder
from vpf_sim.replay.records import ReplayManifest
from vpf_sim.replay.replay_folder import ReplayFolder

ASKED: dict[str, Any] = {
    "schema": 1,
    "command": "sweep",
    "plan": {"scenario": ["town04"], "weather": ["clear"], "driver": ["pid"], "seeds": "0:5"},
    "fingerprint": {"python": "3.11.9"},
    "scenarios": {"town04": "abc"},
    "weathers": {"clear": "def"},
}


@pytest.mark.parametrize(("kind", "module"), [(RunFolder, run_folder), (ReplayFolder, replay_folder)])
def test_of_two_runs_that_begin_at_once_one_is_refused(
    kind: Any, module: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other begins after this one found the folder empty, and before it locks it."""
    manifest, lock = (Manifest if kind is RunFolder else ReplayManifest), module.locked
    other = {**ASKED, "command": "replay", "plan": {"driver": "other", "drives": {}}, "drivers": {}, "recordings": {}}
    first = manifest.model_validate({**other, "plan": {"driver": "one", "drives": {}}})
    second = manifest.model_validate(other)

    def late(path: Path) -> Any:
        monkeypatch.setattr(module, "locked", lock)
        kind(path, second).close()
        return lock(path)

    monkeypatch.setattr(module, "locked", late)
    with pytest.raises(InputError, match="expected an empty or new"):
        kind(tmp_path / "run", first)
    assert json.loads((tmp_path / "run" / MANIFEST).read_text("utf-8"))["plan"]["driver"] == "other"
    kind(tmp_path / "run", second, resume=True).close()


def test_a_folder_is_locked_until_its_files_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, unlink, removed = RunFolder(tmp_path / "run", Manifest.model_validate(ASKED)), Path.unlink, []

    def watched(path: Path, missing_ok: bool = False) -> None:
        if path.parent == folder.path and path.exists():
            with pytest.raises(InputError, match="in use by another run"):
                run_folder.locked(folder.path)
            removed.append(path.name)
        unlink(path, missing_ok)

    monkeypatch.setattr(Path, "unlink", watched)
    folder.discard()
    assert MANIFEST in removed
    assert not folder.path.exists()


def test_on_windows_a_folder_is_removed_as_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It removes no file that is open, as the lock is while it is held."""
    folder, unlink = RunFolder(tmp_path / "run", Manifest.model_validate(ASKED)), Path.unlink

    def refused(path: Path, missing_ok: bool = False) -> None:
        if path.name == run_folder.LOCK:
            try:
                run_folder.locked(path.parent).release()
            except InputError:
                raise PermissionError(13, "used by another process", str(path)) from None
        unlink(path, missing_ok)

    monkeypatch.setattr(system, "WINDOWS", True)
    monkeypatch.setattr(Path, "unlink", refused)
    folder.discard()
    assert not folder.path.exists()


@pytest.mark.parametrize("lock", [filelock.FileLock, filelock.SoftFileLock])
def test_a_lock_with_content_is_no_file_of_the_user(lock: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On file systems without locks, the holder's process is written into the file."""
    monkeypatch.setattr(run_folder, "FileLock", lock)
    if lock is filelock.FileLock:
        (tmp_path / ".lock").write_text("4194304\nsome-host\n")
    folder = RunFolder(tmp_path, Manifest.model_validate(ASKED))
    with pytest.raises(InputError, match="in use by another run"):
        RunFolder(tmp_path, Manifest.model_validate(ASKED), resume=True)
    folder.discard(keep_folder=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("fault", [KeyboardInterrupt(), OSError(28, "No space left on device")])
def test_a_run_that_cannot_begin_leaves_the_folder_unlocked(
    fault: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise fault

    with monkeypatch.context() as patched:
        patched.setattr(run_folder, "write_json", refuse)
        with pytest.raises(type(fault)) as caught:
            RunFolder(tmp_path / "run", Manifest.model_validate(ASKED))
    assert caught.value.__traceback__ is not None, "whose frames keep the folder alive, as in a notebook"
    RunFolder(tmp_path / "run", Manifest.model_validate(ASKED)).close()


def test_a_run_that_is_removed_meanwhile_is_not_the_latest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("a", "b"):
        RunFolder(tmp_path / name, Manifest.model_validate(ASKED)).close()
    exists = Path.exists

    def removing(path: Path, **options: bool) -> bool:
        found = exists(path, **options)
        if path == tmp_path / "b" / "episodes.jsonl":
            shutil.rmtree(path.parent)
        return found

    monkeypatch.setattr(Path, "exists", removing)
    assert located(tmp_path / "latest") == tmp_path / "a"
