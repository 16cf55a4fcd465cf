"""Write the table of hashes that frames must have on every machine, after a change of what they show.

Run `python scripts/frame_hashes.py` on any machine, and say in the changelog that frames differ from those before.
"""

from pathlib import Path

from vpf_sim import files, machine
from vpf_sim.machine import equal_frames

TABLE = Path(machine.__path__[0]) / "frame_hashes.toml"
HEADER = "# SHA-256 over frames by road, weather and camera: equal on every machine. Made by scripts/frame_hashes.py.\n"


def main() -> None:
    """Draw all combinations and write their hashes."""
    lines = [f'"{name}" = "{digest}"\n' for name, digest in equal_frames.drawn()]
    files.write_text(TABLE, HEADER + "".join(lines))
    print(f"{len(lines)} hashes in {TABLE}")


if __name__ == "__main__":
    main()
