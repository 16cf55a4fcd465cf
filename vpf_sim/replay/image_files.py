"""Pictures in files, one a frame: in the order of their numbers, of one size, decoded when they are asked for."""

import re
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay.recording import Frame
from vpf_sim.types import Image

SUFFIXES = (".png", ".jpg", ".jpeg")
PNG, JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8"
ENDS = {".png": b"IEND", ".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9"}
TAIL_BYTES = 64  # in which the end of a whole file lies
HEAD_BYTES = 1 << 16  # in which the size of a JPEG stands, behind its thumbnail


def listed(folder: Path) -> list[Path]:
    """The pictures of a folder, frame_2 before frame_10."""
    files = [path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES]
    return sorted(files, key=lambda path: [int(part) if part.isdigit() else part for part in _parts(path.name)])


def _parts(name: str) -> list[str]:
    return re.split(r"(\d+)", name)


def size(files: Sequence[Path]) -> tuple[int, int]:
    """(width, height) px of all these files, which must be readable and alike; at least two of them."""
    if len(files) < 2:
        where = files[0].parent if files else "the drive"
        raise InputError(f"{where}: expected two images or more, found {len(files)}")
    first = _size(files[0])
    for file in files[1:]:
        if (other := _size(file)) != first:
            expected, actual = (f"{width} x {height}" for width, height in (first, other))
            raise InputError(f"{file}: expected an image of {expected} px like the first, got {actual}")
    return first


def frames(files: Sequence[Path]) -> Iterator[Frame]:
    """Each file's picture; one that is cut off or damaged is a gap."""
    for index, file in enumerate(files):
        fault = _cut_off(file)
        image = None if fault else decode(file)
        yield Frame(index, image, fault or ("" if image is not None else f"{file.name}: does not decode"))


def decode(file: Path) -> Image | None:
    """(H, W, 3) RGB; None if it is none."""
    decoded = cv2.imdecode(np.fromfile(file, np.uint8), cv2.IMREAD_COLOR) if file.stat().st_size else None
    if decoded is None:
        return None
    return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False)


def _cut_off(file: Path) -> str:
    """Why the file is not whole, or nothing: decoders fill what is missing with grey and say nothing."""
    with file.open("rb") as stream:
        stream.seek(max(0, file.stat().st_size - TAIL_BYTES))
        tail = stream.read()
    return "" if ENDS[file.suffix.lower()] in tail else f"{file.name}: the file is cut off"


def _size(file: Path) -> tuple[int, int]:
    """(width, height) px by the file's first bytes."""
    try:
        with file.open("rb") as stream:
            head = stream.read(HEAD_BYTES)
    except OSError as error:
        raise InputError(f"{file}: expected an image, cannot be read: {error.strerror}") from None
    found = _png_size(head) if head.startswith(PNG) else _jpeg_size(head) if head.startswith(JPEG) else None
    if found is None and (image := decode(file)) is not None:
        found = (image.shape[1], image.shape[0])
    if found is None:
        raise InputError(f"{file}: expected an image, got {file.stat().st_size} bytes that do not decode as one")
    return found


def _png_size(head: bytes) -> tuple[int, int] | None:
    if len(head) < 24:
        return None
    width, height = struct.unpack(">II", head[16:24])
    return int(width), int(height)


def _jpeg_size(head: bytes) -> tuple[int, int] | None:
    """By the frame header, marker SOF0 to SOF15 but for the tables DHT, JPG and DAC (ITU-T T.81, B.2.2)."""
    at = 2
    while at + 9 <= len(head) and head[at] == 0xFF:
        marker, length = head[at + 1], int.from_bytes(head[at + 2 : at + 4], "big")
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", head[at + 5 : at + 9])
            return int(width), int(height)
        at += 2 + length
    return None
