"""SHA-256 of all frames of an episode, on a thread: hashlib releases the GIL, so steps do not wait."""

from hashlib import sha256
from queue import SimpleQueue
from threading import Thread
from types import TracebackType

from vpf_sim.types import Image


class FrameHasher:
    """A context manager: `add` each frame, read `hexdigest` after its end. Frames must not change."""

    def __init__(self) -> None:
        self._digest = sha256()
        self._frames = 0
        self._queue: SimpleQueue[Image | None] = SimpleQueue()
        self._thread = Thread(target=self._work, name="frame hasher", daemon=True)

    def __enter__(self) -> "FrameHasher":
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._queue.put(None)
        self._thread.join()

    def add(self, frame: Image) -> None:
        """Queue a frame; the thread reads it later."""
        self._frames += 1
        self._queue.put(frame)

    def hexdigest(self) -> str | None:
        """The hash; None without frames."""
        return self._digest.hexdigest() if self._frames else None

    def _work(self) -> None:
        while (frame := self._queue.get()) is not None:
            self._digest.update(frame.tobytes() if not frame.flags.c_contiguous else frame.data)
