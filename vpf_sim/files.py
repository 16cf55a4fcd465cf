"""Files on the disk: written whole or not at all, and named so that any system takes the name."""

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from unicodedata import normalize

DRAFT = ".draft"  # the ending of a file that is not finished
MOST_BYTES = 64  # of a name, but for its hash
PLAIN = re.compile(r"(?!-)[\w@-]+(?: [\w@-]+)*")
RESERVED = re.compile(r"con|prn|aux|nul|com\d|lpt\d", re.IGNORECASE)  # names of devices on Windows


class Draft:
    """A file beside `path` that takes its place by `commit`: until then, the former file stays as it is.

    What is no regular file, such as /dev/stdout or a pipe, has nothing to lose and is written directly.
    """

    def __init__(self, path: Path) -> None:
        """OSError where the file cannot be written; a folder that is missing is made."""
        self.path = path
        self._target = Path(os.path.realpath(path))  # a link goes on leading to the file
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
        """Put what was written in the place of the file; OSError if that fails, and then the former one stays."""
        if self._direct:
            return
        try:
            with self.file.open("rb") as written:
                os.fsync(written.fileno())
            self.file.replace(self._target)
        except OSError as error:
            self.discard()
            raise self.fault(error) from None

    def discard(self) -> None:
        """Remove what was written."""
        if not self._direct:
            self.file.unlink(missing_ok=True)

    def fault(self, error: Exception) -> OSError:
        """What went wrong while this was written, as an OSError that names the file and says the reason."""
        code = getattr(error, "errno", None)
        code = code if isinstance(code, int) and code > 0 else errno.EIO
        reason = os.strerror(code) if getattr(error, "errno", None) else str(error)
        return OSError(code, reason, str(self.path))


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """The place to write to: it becomes the file `path` at the end, or is removed if anything goes wrong."""
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


def write_bytes(path: Path, content: bytes) -> None:
    """The whole file, or the former one and OSError."""
    with replacing(path) as draft:
        draft.write_bytes(content)


def write_text(path: Path, text: str) -> None:
    """The whole file in UTF-8, or the former one and OSError; "?" stands for what UTF-8 does not have."""
    write_bytes(path, text.encode("utf-8", "replace"))


def file_name(text: str, label: str | None = None) -> str:
    """A name for a file of what is called `text`, without an ending; different texts have different names.

    Letters, digits, "_", "-", "@" and single spaces are kept. Any other text is replaced by what is plain in it, or in
    `label`, and a hash of the whole text. Texts that differ in case only may differ in case only here, too.
    """
    if PLAIN.fullmatch(text) and not RESERVED.fullmatch(text) and normalize("NFKC", text) == text and _is_short(text):
        return text
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", text if label is None else label).lstrip("-")[:MOST_BYTES]
    return f"{plain or 'unnamed'}-{sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()[:8]}"


def _is_short(text: str) -> bool:
    return len(text.encode("utf-8", "surrogatepass")) <= MOST_BYTES
