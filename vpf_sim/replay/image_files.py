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
LAST_SCAN, END_OF_IMAGE, LAST_CHUNK = b"\xff\xda", b"\xff\xd9", b"IEND"
HEAD_BYTES = 1 << 16  # in which the size of a JPEG stands, behind its thumbnail


def listed(folder: Path) -> list[Path]:
    """The pictures of a folder, frame_2 before frame_10."""
    files = [path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and not path.name.startswith(".")]
    return sorted(files, key=lambda path: [int(part) if part.isdecimal() else part for part in _parts(path.name)])


def _parts(name: str) -> list[str]:
    return re.split(r"(\d+)", name)


def size(files: Sequence[Path], folder: Path) -> tuple[int, int]:
    """(width, height) px of all these files of a folder, which must be readable and alike; at least two of them."""
    if len(files) < 2:
        raise InputError(f"{folder}: expected two images or more, found {len(files)}")
    first = _size(files[0])
    for file in files[1:]:
        if (other := _size(file)) != first:
            expected, actual = (f"{width} x {height}" for width, height in (first, other))
            raise InputError(f"{file}: expected an image of {expected} px like the first, got {actual}")
    shown = decode(files[0].read_bytes())  # turned, if the camera says so
    return first if shown is None else (shown.shape[1], shown.shape[0])


def frames(files: Sequence[Path], expected: tuple[int, int]) -> Iterator[Frame]:
    """Each file's picture; one that is cut off, damaged or of another (width, height) is a gap."""
    for index, file in enumerate(files):
        content = file.read_bytes()
        image = None if _cut_off(content) else decode(content)
        if image is None:
            fault = f"{file.name}: the file is cut off" if _cut_off(content) else f"{file.name}: does not decode"
            yield Frame(index, None, fault)
        elif image.shape[1::-1] != expected:
            yield Frame(index, None, f"{file.name}: {image.shape[1]} x {image.shape[0]} px, unlike the others")
        else:
            yield Frame(index, image)


def decode(content: bytes) -> Image | None:
    """(H, W, 3) RGB; None if it is none."""
    decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR) if content else None
    if decoded is None:
        return None
    return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False)


def _cut_off(content: bytes) -> bool:
    """Whether the end of the picture is missing: decoders fill it with grey and say nothing. Cameras may write more."""
    if content.startswith(JPEG):
        return END_OF_IMAGE not in content[max(0, content.rfind(LAST_SCAN)) :]
    return content.startswith(PNG) and LAST_CHUNK not in content


def _size(file: Path) -> tuple[int, int]:
    """(width, height) px by the file's first bytes."""
    try:
        with file.open("rb") as stream:
            head = stream.read(HEAD_BYTES)
    except OSError as error:
        raise InputError(f"{file}: expected an image, cannot be read: {error.strerror}") from None
    found = _png_size(head) if head.startswith(PNG) else _jpeg_size(head) if head.startswith(JPEG) else None
    if found is None and (image := decode(file.read_bytes())) is not None:
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
