"""Reading an OpenDRIVE file's XML: elements, numbers, and one line for what is wrong."""

import math
import re
import xml.etree.ElementTree as ET
from functools import lru_cache
from pathlib import Path

from vpf_sim.errors import InputError, shown

Element = ET.Element
# What some programs write before the XML declaration, where XML allows nothing: comments and other instructions.
BEFORE_DECLARATION = re.compile(rb"\A(?:\xef\xbb\xbf)?(?:\s+|<!--.*?-->|<\?(?!xml\s).*?\?>)*(?=<\?xml\s)", re.DOTALL)
UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
LARGEST = 1e9  # no number of a map is larger: coordinates are metres


def read(path: Path, where: str) -> Element:
    """The root of an OpenDRIVE file; `where` is the file and key that name it. Raises InputError."""
    try:
        status = path.stat()
        return _parsed(path, status.st_mtime_ns, status.st_size)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = error.strerror if isinstance(error, OSError) else "not a file's name"
        raise InputError(f"{where}: expected a readable OpenDRIVE file, got {path}: {reason}") from None


@lru_cache(maxsize=2)
def _parsed(path: Path, changed_ns: int, size: int) -> Element:  # noqa: ARG001  # a changed file is read again
    data = path.read_bytes()
    # A document type can define entities that grow without end. UTF-16 has a zero in each of its characters.
    if b"<!ENTITY" in data.replace(b"\0", b""):
        raise InputError(f"{path}: expected XML without entities of its own, got <!ENTITY")
    try:
        root = ET.fromstring(_declared_first(data))
    except (ET.ParseError, LookupError, ValueError) as error:  # the others: an encoding that Python lacks
        raise InputError(f"{path}: expected XML, got: {error}") from None
    if root.tag.startswith("{"):  # later versions may have a namespace
        for element in root.iter():
            element.tag = element.tag.rpartition("}")[2]
    if root.tag != "OpenDRIVE":
        raise InputError(f"{path}: expected the root element OpenDRIVE, got {shown(root.tag)}")
    return root


def _declared_first(data: bytes) -> bytes | str:
    """A file's content that begins with its XML declaration, if it has one."""
    if not data.startswith(UTF16_MARKS):
        return BEFORE_DECLARATION.sub(b"", data)
    return BEFORE_DECLARATION.sub(b"", data.decode("utf-16").encode()).decode()  # text: its declaration is passed over


def number(element: Element, key: str, where: str, default: float | None = None) -> float:
    """A number of an element; `where` is the file and the element in messages."""
    text = element.get(key)
    if text is None and default is not None:
        return default
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not abs(value) <= LARGEST:
        raise InputError(
            f"{where}.{key}: expected a number up to {LARGEST:g}, got {'none' if text is None else shown(text)}"
        )
    return value


def integer(element: Element, key: str, where: str) -> int:
    """An integer of an element."""
    text = element.get(key)
    try:
        return int(text or "")
    except ValueError:
        got = "none" if text is None else shown(text)
        raise InputError(f"{where}.{key}: expected an integer, got {got}") from None
