"""A recording of messages: whole when it is closed, and until then not to be taken for one."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, ClassVar

from kendon.errors import DataError
from kendon.outputs import make_folder_for


class Recording(ABC):
    """Writes messages into a file, which is there when the recording is closed.

    A disk that is full, or a folder that goes, ends the recording, and nothing else: a robot
    that greets goes on. Then `trouble` says so, and so does the end.

    Args:
        path: of the file.

    Raises:
        DataError: the file has another ending, exists already, or cannot be made.
        MissingExtraError: rosbags is not installed.
    """

    suffix: ClassVar[str]  # what the file's name ends in
    system: ClassVar[str]  # whose messages these are

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() != self.suffix:
            raise DataError(f"a recording of {self.system} ends in {self.suffix}", file=path)
        if path.exists():
            raise DataError("this recording exists already; name another one", file=path)
        make_folder_for(path)
        self.count = 0  # messages
        self.trouble = ""  # a sentence, when no more can be recorded
        self._path = path
        self._connections: dict[Hashable, Any] = {}
        try:
            # What is broken off must not be taken for a whole recording.
            self._folder = Path(tempfile.mkdtemp(prefix=f".{path.stem}-", dir=path.parent))
        except OSError as error:
            raise DataError(f"cannot be recorded into ({error.strerror})", file=path) from None
        try:
            self._writer, self._unfinished, self._handle = self._make_writer(self._folder)
        except BaseException as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            if isinstance(error, OSError):
                raise DataError(f"cannot be recorded into ({error.strerror})", file=path) from None
            raise
        self._open = True

    @abstractmethod
    def _make_writer(self, folder: Path) -> tuple[Any, Path, BinaryIO]:
        """A writer of rosbags, open, the file in a folder that it writes, and its handle."""

    def close(self) -> None:
        """Finish the file; one without any message is not kept. Again, it does nothing.

        Raises:
            DataError: it could not be recorded to the end.
        """
        if not self._open:
            return
        self._open = False
        if not self.trouble:
            with self._in_trouble():
                self._writer.close()
                if self.count:
                    os.replace(self._unfinished, self._path)
        if not self.trouble:
            shutil.rmtree(self._folder, ignore_errors=True)
            return
        with contextlib.suppress(OSError):  # it tries to write the rest, and is closed all the same
            self._handle.close()
        if self.count and self._unfinished.exists():
            left = f"what was written until then is in {self._unfinished}, without an end"
        else:
            left = "nothing of it is left"
            shutil.rmtree(self._folder, ignore_errors=True)
        raise DataError(f"{self.trouble}; {left}")

    def _write(self, key: Hashable, connect: Callable[[], Any], came: int, raw: bytes) -> None:
        """Record a message.

        Args:
            key: what its connection is known by.
            connect: makes the connection.
            came: when it did [ns].
            raw: its bytes.
        """
        if self.trouble or not self._open:
            return
        with self._in_trouble():
            if key not in self._connections:
                self._connections[key] = connect()
            self._writer.write(self._connections[key], came, raw)
            self.count += 1

    @contextlib.contextmanager
    def _in_trouble(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            reason = error.strerror or str(error)
            self.trouble = f"{self._path}: the recording has ended ({reason})"
