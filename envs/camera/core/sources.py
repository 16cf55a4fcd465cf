"""The C files that the core was built from."""

from hashlib import sha256
from pathlib import Path


def digest(folder: Path) -> str:
    """SHA-256 over the C files of a folder; empty if it has none."""
    files = sorted(folder.glob("*.[ch]"))
    content = b"".join(path.name.encode() + b"\n" + path.read_bytes() for path in files)
    return sha256(content).hexdigest() if files else ""
