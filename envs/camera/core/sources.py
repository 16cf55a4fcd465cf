"""The C files that the core was built from."""

from hashlib import sha256
from pathlib import Path


def digest(folder: Path) -> str:
    """SHA-256 over the C files in a folder and below; empty if there are none."""
    files = sorted(folder.rglob("*.[ch]"))
    content = b"".join(path.relative_to(folder).as_posix().encode() + b"\n" + path.read_bytes() for path in files)
    return sha256(content).hexdigest() if files else ""
