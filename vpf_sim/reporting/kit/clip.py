"""Pictures and videos inside a page: JPEG, sheets of pictures, data URIs, clips."""

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.reporting import video
from vpf_sim.types import Image

POSTER_QUALITY = 70  # of JPEG
MOST_INSIDE_BYTES = 4_000_000  # of an embedded video; larger ones are linked


@dataclass(frozen=True, slots=True)
class Clip:
    """A video of a page, played by the macro `film`."""

    source: str  # a data URI, or the address of a file beside the page
    poster: str  # a data URI of a frame, or empty
    size_px: tuple[int, int] | None  # width and height of the frame

    @property
    def is_linked(self) -> bool:
        """Whether the video is a file beside the page."""
        return not self.source.startswith("data:")

    @classmethod
    def embedded(cls, content: bytes, poster: Image) -> "Clip":
        """The bytes of an .mp4 inside the page."""
        return cls._of(data_uri("video/mp4", content), poster)

    @classmethod
    def of_file(cls, file: Path, folder: Path) -> "Clip | None":
        """A video in a page's folder, inside the page unless it is large; None if there is no such file."""
        if not file.exists():
            return None
        frame = video.middle_frame(file)
        large = file.stat().st_size > MOST_INSIDE_BYTES
        source = file.relative_to(folder).as_posix() if large else data_uri("video/mp4", file.read_bytes())
        return cls._of(source, frame)

    @classmethod
    def _of(cls, source: str, poster: Image | None) -> "Clip":
        if poster is None:
            return cls(source, "", None)
        height, width = poster.shape[:2]
        return cls(source, data_uri("image/jpeg", jpeg(poster, POSTER_QUALITY)), (width, height))


def jpeg(image: Image, quality: int) -> bytes:
    """JPEG bytes of an RGB image (H, W, 3); quality 0 to 100."""
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    done, encoded = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)
    if not done:
        raise RuntimeError("the image could not be encoded")
    return encoded.tobytes()


def sheet(pictures: Sequence[Image], columns: int) -> Image:
    """Images of one size in a grid with this many columns."""
    rows = [np.hstack(pictures[i : i + columns]) for i in range(0, len(pictures), columns)]
    return np.vstack(rows)


def data_uri(kind: str, content: bytes) -> str:
    """Content as an address that pages embed; `kind` is its MIME type."""
    return f"data:{kind};base64,{b64encode(content).decode('ascii')}"
