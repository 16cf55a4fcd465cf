"""The layouts in which recordings come, and which one a folder has."""

from pathlib import Path

from vpf_sim.errors import InputError
from vpf_sim.replay import kitti
from vpf_sim.replay.recording import Reader, Recording

READERS: tuple[Reader, ...] = (kitti,)  # the first that recognises a folder reads it


def read(folder: Path | str) -> Recording:
    """The recording in `folder`, its layout told by its content; what is wrong with it is an InputError of one line."""
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(
            f"{folder}: expected the folder of a drive, found {'a file' if folder.exists() else 'nothing'}"
        )
    for reader in READERS:
        if reader.recognises(folder):
            return reader.read(folder)
    found = ", ".join(sorted(path.name for path in folder.iterdir())[:8]) or "nothing"
    expected = "; or ".join(f"{reader.LAYOUT}: {reader.EXPECTED}" for reader in READERS)
    raise InputError(f"{folder}: found {found}; expected one of {expected}")
