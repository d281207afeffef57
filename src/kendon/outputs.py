"""Files to write: looked at before the work, made whole or not at all after it.

One rule for all of them: a folder that is missing is made, with those above it, when there is
something to put into it; until then nothing is made.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from kendon.errors import DataError


def check_file(path: str | Path) -> None:
    """Refuse, before the work, a file that could not be written after it; nothing is made.

    Raises:
        DataError: it is a folder, may not be written to, or its folder cannot be made or may not
            be written to.
    """
    path = Path(path)
    try:
        if path.is_dir():
            raise DataError("cannot be written, as this is a folder; name a file", file=path)
        if path.is_file():
            with path.open("ab"):  # whether it may be written to; this leaves it as it is
                pass
    except OSError as error:
        raise _cannot(path, error) from None
    if not _is_device(path):
        _check_place(path.parent, path)
    elif not os.access(path, os.W_OK):
        raise DataError("may not be written to", file=path)


def check_folder(folder: str | Path) -> None:
    """Refuse, before the work, a folder that could not be written into after it; likewise.

    Raises:
        DataError: it is a file, cannot be made or may not be written to.
    """
    _check_place(Path(folder), Path(folder))


def make_folder_for(path: str | Path) -> None:
    """Make the folder of a file that is about to be written.

    Raises:
        DataError: it cannot be made.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _cannot(path, error) from None


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """A file beside the one to write, which takes its place when it is written.

    Nobody ever sees half of it, and if anything goes wrong, all is as before. It has the same
    ending, for writers that go by it. A device, such as /dev/stdout, is written to itself, and of
    a link what it leads to. A file that is replaced hands its permissions on.

    Raises:
        DataError: the file cannot be written.
    """
    path = Path(path)
    try:
        target = path.resolve() if path.is_symlink() else path
        if _is_device(target):
            yield target
            return
        # With the permissions that the user's umask leaves, unlike those of tempfile.
        part = target.with_name(f".{uuid.uuid4().hex}.part{target.suffix}")
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield part
            if target.exists():
                shutil.copymode(target, part)
            part.replace(target)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise _cannot(path, error) from None


def write_text(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all, making its folder if need be.

    Raises:
        DataError: the file cannot be written.
    """
    data = text.encode()
    with whole_file(path) as part:
        part.write_bytes(data)


def _is_device(path: Path) -> bool:
    return path.exists() and not path.is_file() and not path.is_dir()


def _check_place(folder: Path, target: Path) -> None:
    """Refuse a folder that neither can be written to nor be made."""
    try:
        there = folder.absolute()
        while not there.exists():
            there = there.parent
        if not there.is_dir():
            what = "this" if there == target.absolute() else there
            raise DataError(f"cannot be written, as {what} is not a folder", file=target)
        # Permissions alone do not tell: a file system may be read-only, or be none for files.
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise _cannot(target, error) from None


def _cannot(path: Path, error: OSError) -> DataError:
    return DataError(f"cannot be written ({error.strerror})", file=path)
