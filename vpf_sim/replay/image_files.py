"""Images in files, one a frame: ordered by number, of one size, decoded on demand."""

import os
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import PIL.Image  # comes with matplotlib
from numpy.typing import NDArray

from vpf_sim.errors import InputError
from vpf_sim.types import Image

SUFFIXES = (".png", ".jpg", ".jpeg")
SLASHES = re.compile(r"[/\\]")
PNG, JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8"
LAST_SCAN, END_OF_IMAGE, LAST_CHUNK = b"\xff\xda", b"\xff\xd9", b"IEND"
PNG_DEPTH, DEEP = 24, b"\x10"  # position of the bit depth in a PNG; 16 bits
DEPTHS = (8, 10, 12, 14, 16)  # bits that cameras use of 16
SAMPLED = 5  # images per drive, for the bit depth
MOST_MISSING = 2  # times as many numbers as images: above this they do not count images


@dataclass(frozen=True, slots=True)
class Frame:
    """Image number `index` of a recording, or the reason for a gap."""

    index: int
    image: Image | None  # (H, W, 3) RGB
    fault: str = ""  # one line; empty where there is an image
    time_s: float | None = None  # when the image was taken; None: at its frame time


def listed(folder: Path) -> list[Path]:
    """The images in a folder, frame_2 before frame_10."""
    files = [path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and not path.name.startswith(".")]
    return sorted(files, key=lambda path: [int(part) if part.isdecimal() else part for part in _parts(path.name)])


def _parts(name: str) -> list[str]:
    return re.split(r"(\d+)", name)


def steps(files: Sequence[Path]) -> NDArray[np.intp]:
    """(N,) position of each image by the number in its name; a step over one is a gap.

    If the names do not hold one counting number each, no image is missing.
    """
    even = np.arange(len(files))
    stems = [_parts(file.stem) for file in files]
    if len({len(stem) for stem in stems}) != 1:
        return even
    varying = [k for k, part in enumerate(zip(*stems, strict=True)) if len(set(part)) > 1]
    if len(varying) != 1 or not all(stem[varying[0]].isdecimal() for stem in stems):
        return even
    numbers = [int(stem[varying[0]]) for stem in stems]
    counts = Counter(after - before for before, after in pairwise(numbers))
    if 0 in counts:
        twice = next(k for k, (before, after) in enumerate(pairwise(numbers)) if before == after)
        raise InputError(f"{files[twice + 1]}: expected one image of this number, found also {files[twice].name}")
    usual = counts.most_common(1)[0][0]
    if any(step % usual for step in counts) or (numbers[-1] - numbers[0]) // usual > MOST_MISSING * len(numbers):
        return even
    return np.array([(number - numbers[0]) // usual for number in numbers])


def with_gaps(files: Sequence[Path]) -> tuple[list[Path | None], list[str]]:
    """The images, None for each missing number, and a note about them."""
    places = steps(files).tolist()
    slots: list[Path | None] = [None] * (places[-1] + 1)
    for place, file in zip(places, files, strict=True):
        slots[place] = file
    if len(slots) == len(files):
        return slots, []
    first = next(k for k, (before, after) in enumerate(pairwise(places)) if after > before + 1)
    between = f"{files[first].name} and {files[first + 1].name}"
    missing = len(slots) - len(files)
    return slots, [f"{missing} of {len(slots)} images are missing by their numbers, the first between {between}"]


def size(files: Sequence[Path], folder: Path) -> tuple[int, int]:
    """(width, height) px of all the files, at least two; InputError where one differs or is unreadable."""
    if len(files) < 2:
        raise InputError(f"{folder}: expected two images or more, found {len(files)}")
    first = _size(files[0])
    for file in files[1:]:
        if (other := _size(file)) != first:
            expected, actual = (f"{width} x {height}" for width, height in (first, other))
            raise InputError(f"{file}: expected an image of {expected} px like the first, got {actual}")
    whole = (file.read_bytes() for file in files)
    shown = next((image for content in whole if (image := _image(content)) is not None), None)
    if shown is None:
        raise InputError(f"{folder}: expected images that can be read, found none among {len(files)}")
    return shown.shape[1], shown.shape[0]  # rotated as the camera says


def frames(files: Sequence[Path | None], expected: tuple[int, int]) -> Iterator[Frame]:
    """Each file's image; a missing, truncated, damaged or differently sized one is a gap."""
    bits = used_bits([file for file in files if file is not None])
    for index, file in enumerate(files):
        if file is None:
            yield Frame(index, None, f"image {index} is missing")
            continue
        content = file.read_bytes()
        image = _image(content, bits)
        if image is None:
            fault = f"{file.name}: the file is truncated" if _cut_off(content) else f"{file.name}: does not decode"
            yield Frame(index, None, fault)
        elif image.shape[1::-1] != expected:
            yield Frame(index, None, f"{file.name}: {image.shape[1]} x {image.shape[0]} px, unlike the others")
        else:
            yield Frame(index, image)


def used_bits(files: Sequence[Path]) -> int:
    """Number of bits that 16-bit images use, by a sample of them; 16 if there are none."""
    some = [file.read_bytes() for file in files[:: max(1, len(files) // SAMPLED)]]
    deep = [
        _decoded(content) for content in some if content.startswith(PNG) and content[PNG_DEPTH : PNG_DEPTH + 1] == DEEP
    ]
    highest = max((int(image.max()) for image in deep if image is not None), default=0)
    return next(bits for bits in DEPTHS if highest < 1 << bits) if highest else 16


def decode(content: bytes, bits: int = 16) -> Image | None:
    """(H, W, 3) RGB of 8 bits, None if it is no image. 16-bit images may use fewer `bits`."""
    decoded = _decoded(content)
    if decoded is None:
        return None
    if decoded.dtype == np.uint16:
        decoded = np.minimum(decoded >> (bits - 8), 255)
    return cv2.cvtColor(decoded.astype(np.uint8), cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False)


def _image(content: bytes, bits: int = 16) -> Image | None:
    """`decode`, but None for a truncated file, too."""
    return None if _cut_off(content) else decode(content, bits)


def _decoded(content: bytes) -> NDArray[Any] | None:
    """(H, W, 3) BGR of 8 or 16 bits; None if it is no image."""
    if not content:
        return None
    try:
        return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH)
    except cv2.error:  # its claimed size is too large for OpenCV
        return None


def _cut_off(content: bytes) -> bool:
    """Whether the end of the image is missing, which decoders fill with grey; bytes after it are allowed."""
    if content.startswith(JPEG):
        return END_OF_IMAGE not in content[max(0, content.rfind(LAST_SCAN)) :]
    return content.startswith(PNG) and LAST_CHUNK not in content


def _size(file: Path) -> tuple[int, int]:
    """(width, height) px by the file's head, without decoding it."""
    try:
        with PIL.Image.open(file) as image:
            return image.size
    except Exception:  # Pillow raises many kinds on damaged files
        content = _content(file)
    if (decoded := decode(content)) is None:
        raise InputError(f"{file}: expected an image, got {len(content)} bytes that do not decode as one")
    return decoded.shape[1], decoded.shape[0]


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise InputError(f"{file}: expected an image, cannot be read: {error.strerror}") from None


def name_of(path: str) -> str:
    """The last part of a path of any system."""
    return SLASHES.split(path.strip())[-1]


def resolve(folder: Path, path: str) -> Path:
    """The file in `folder` that a path of any system refers to, or where it should be.

    The longest existing end of the path is taken: center/1.jpg for C:\\me\\drive\\center\\1.jpg.
    """
    written = folder / path
    parts = [part for part in SLASHES.split(path.strip()) if part not in ("", ".", "..") and not part.endswith(":")]
    inside = [folder.joinpath(*parts[first:]) for first in range(len(parts))]
    ordered = [*inside, written] if written == Path(path) else [written, *inside]
    # os.path.exists, since Path.exists raises on names that are too long.
    return next((file for file in ordered if os.path.exists(file)), folder.joinpath(*parts[-2:]))


def resolve_all(folder: Path, paths: Sequence[str], suffixes: Sequence[str]) -> list[Path]:
    """The files that `paths` refer to.

    A file that is not found by `resolve` may be the only one of its name, with one of the suffixes, in any folder.
    """
    found = [resolve(folder, path) for path in paths]
    if all(os.path.exists(file) for file in found):
        return found
    anywhere: dict[str, list[Path]] = {}
    for file in folder.rglob("*"):
        if file.suffix.lower() in suffixes:
            anywhere.setdefault(file.name, []).append(file)
    only = {name: files[0] for name, files in anywhere.items() if len(files) == 1}
    return [file if os.path.exists(file) else only.get(file.name, file) for file in found]
