"""A text stream that never keeps its writer waiting, whatever becomes of the terminal or pipe behind it."""

from __future__ import annotations

import contextlib
import io
import os
import queue
import threading
from typing import TextIO

MOST_PENDING = 1000
"""Number of texts that may wait for a slow reader; the rest is dropped."""


class Outlet(io.TextIOBase):
    """Hands texts to a thread, which writes them; a stream that is full, slow or closed stops nobody.

    The thread writes to the descriptor: stuck in Python's own buffer it would keep the program from ending.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._descriptor = _descriptor_of(stream)
        self._pending: queue.Queue[str | None] = queue.Queue(MOST_PENDING)
        self._thread = threading.Thread(target=self._write_all, daemon=True, name="outlet")
        self._thread.start()

    @property
    def encoding(self) -> str:  # type: ignore[override]  # a plain attribute in the base
        return self._stream.encoding or "utf-8"

    def fileno(self) -> int:
        return self._stream.fileno()

    def isatty(self) -> bool:
        return self._stream.isatty()

    def writable(self) -> bool:
        return True

    def write(self, text: str) -> int:
        with contextlib.suppress(queue.Full):
            self._pending.put_nowait(text)
        return len(text)

    def finish(self, timeout: float) -> bool:
        """End, after what is pending was written, or after `timeout` [s].

        Returns:
            Whether everything that was pending was dealt with.
        """
        try:
            self._pending.put(None, timeout=timeout)
        except queue.Full:
            return False
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _write_all(self) -> None:
        usable = True
        for text in iter(self._pending.get, None):
            try:
                if usable:
                    self._write(text)
            except (OSError, ValueError):
                usable = False  # nobody reads any more

    def _write(self, text: str) -> None:
        if self._descriptor is None:
            self._stream.write(text)
            self._stream.flush()
            return
        data = text.encode(self.encoding, errors=self._stream.errors or "replace")
        while data:
            data = data[os.write(self._descriptor, data) :]


def _descriptor_of(stream: TextIO) -> int | None:
    """Descriptor of a stream; None where it has none. What the stream still holds goes out first."""
    try:
        descriptor = stream.fileno()
        stream.flush()
    except (OSError, ValueError):
        return None
    return descriptor
