"""Text of users' files, atomic file writes, and file names that every system accepts."""

import codecs
import errno
import json
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from unicodedata import normalize

from vpf_sim.errors import InputError

DRAFT = ".draft"  # suffix of an unfinished file
MOST_BYTES = 64  # of a name, without its hash
PLAIN = re.compile(r"(?!-)[\w@-]+(?: [\w@-]+)*")
RESERVED = re.compile(r"con|prn|aux|nul|com\d|lpt\d", re.IGNORECASE)  # names of devices on Windows


class Draft:
    """A temporary file beside `path`; `commit` moves it to `path`, which stays unchanged until then.

    A path that is not a regular file, such as /dev/stdout or a pipe, is written directly.
    """

    def __init__(self, path: Path) -> None:
        """Create the file and missing folders; OSError where it cannot be written."""
        self.path = path
        self._target = Path(os.path.realpath(path))  # a symbolic link stays a link
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        self._direct = path.exists() and not path.is_file()
        self.file = path if self._direct else self._target.with_name(f"{self._target.name}{DRAFT}")
        if self._direct:
            return
        try:
            if path.exists() and not os.access(path, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            self._target.parent.mkdir(parents=True, exist_ok=True)
            self.file.open("wb").close()
        except OSError as error:
            raise self.fault(error) from None

    def commit(self) -> None:
        """Replace the file by the draft; OSError if that fails, and the former file stays."""
        if self._direct:
            return
        try:
            with self.file.open("r+b") as written:  # Windows syncs no file that is open for reading only
                os.fsync(written.fileno())
            self.file.replace(self._target)
        except OSError as error:
            self.discard()
            raise self.fault(error) from None

    def discard(self) -> None:
        """Remove the draft."""
        if not self._direct:
            self.file.unlink(missing_ok=True)

    def fault(self, error: Exception) -> OSError:
        """An error during writing as an OSError with the file's name and the reason."""
        code = getattr(error, "errno", None)
        code = code if isinstance(code, int) and code > 0 else errno.EIO
        reason = os.strerror(code) if getattr(error, "errno", None) else str(error)
        return OSError(code, reason, str(self.path))


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A draft of `path`: committed at the end of the context, removed on any exception."""
    draft = Draft(path)
    try:
        yield draft.file
    except OSError as error:
        draft.discard()
        if error.filename in (None, str(draft.file)):
            raise draft.fault(error) from None
        raise
    except BaseException:
        draft.discard()
        raise
    draft.commit()


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """A folder that becomes `path` at the end of the context, and is removed on any exception.

    InputError where `path` exists, or its draft does, which another process writes or a killed one left.
    """
    draft = path.with_name(f"{path.name}{DRAFT}")
    for taken in (path, draft):
        if taken.exists() or taken.is_symlink():
            what = "another process writes it, or was killed; remove it" if taken == draft else "got one that exists"
            raise InputError(f"{taken}: expected the name of a new folder: {what}")
    draft.mkdir()
    try:
        yield draft
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        raise
    draft.rename(path)


def read_text(path: Path) -> str:
    """The text of a user's file: UTF-8, or UTF-16 if a byte order mark says so; the mark is left out."""
    content = path.read_bytes()
    is_wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return content.decode("utf-16" if is_wide else "utf-8-sig")


def read_object(path: Path, expected: str = "a JSON object") -> dict[str, object]:
    """The object in a JSON file; InputError where it is none, OSError where it cannot be read."""
    try:
        content = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected {expected}, got something else")
    return content


def write_bytes(path: Path, content: bytes) -> None:
    """Write the file atomically; OSError leaves the former file."""
    with replacing(path) as draft:
        draft.write_bytes(content)


def write_text(path: Path, text: str) -> None:
    """Write the file atomically in UTF-8; characters without an encoding become "?"."""
    write_bytes(path, text.encode("utf-8", "replace"))


def file_name(text: str, label: str | None = None) -> str:
    """A portable file name for `text`, without a suffix; different texts have different names.

    Letters, digits, "_", "-", "@" and single spaces are kept. Other texts become the plain characters of `text` (or of
    `label`) and a hash. Names of texts that differ in case only may differ in case only.
    """
    if PLAIN.fullmatch(text) and not RESERVED.fullmatch(text) and normalize("NFKC", text) == text and _is_short(text):
        return text
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", text if label is None else label).lstrip("-")[:MOST_BYTES]
    return f"{plain or 'unnamed'}-{sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()[:8]}"


def _is_short(text: str) -> bool:
    return len(text.encode("utf-8", "surrogatepass")) <= MOST_BYTES
