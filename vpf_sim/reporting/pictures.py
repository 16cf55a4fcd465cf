"""Image sheets, JPEG encoding, and embedding in pages."""

from base64 import b64encode
from collections.abc import Sequence

import cv2
import numpy as np

from vpf_sim.types import Image


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
