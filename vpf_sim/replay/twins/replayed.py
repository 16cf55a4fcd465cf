"""The frame table of a driver on a recording, replayed as by `vpf-sim replay`."""

from pathlib import Path

from vpf_sim.errors import InputError
from vpf_sim.replay import frame_table, open_loop
from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.run_files import table_path


def replayed(recording: Recording, driver: str, out: Path) -> FrameTable:
    """Replay a driver on a recording and read its frames; InputError where the driver fails."""
    record, _ = open_loop.run(recording, driver, out, with_video=False)
    if record["error"]:
        raise InputError(f"{recording.name}: the driver '{driver}' failed: {record['error']}")
    return frame_table.read(table_path(out, recording.name))
