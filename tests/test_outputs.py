"""Files are written whole or not at all, and what cannot be written is known before the work."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from kendon.errors import DataError
from kendon.outputs import check_file, check_folder, whole_file, write_text

NOT_ROOT = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="nothing is forbidden to root"
)
POSIX = pytest.mark.skipif(os.name == "nt", reason="permissions and devices are POSIX's")


def left(folder: Path) -> list[str]:
    """All that lies in a folder, and below it."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_a_check_makes_nothing_and_changes_nothing(tmp_path: Path) -> None:
    old = tmp_path / "old.txt"
    old.write_text("as before", encoding="utf-8")
    os.utime(old, (1.0, 1.0))
    for file in (old, tmp_path / "new.txt", tmp_path / "far" / "away" / "new.txt"):
        check_file(file)
        check_folder(file.parent)
    assert left(tmp_path) == ["old.txt"]
    assert (old.read_text(encoding="utf-8"), old.stat().st_mtime) == ("as before", 1.0)


def test_a_missing_folder_is_made_with_the_file(tmp_path: Path) -> None:
    write_text(tmp_path / "far" / "away" / "new.txt", "ä\n")
    assert left(tmp_path) == ["far", "far/away", "far/away/new.txt"]
    assert (tmp_path / "far" / "away" / "new.txt").read_bytes() == b"\xc3\xa4\n"


@pytest.mark.parametrize("check", [check_file, check_folder, lambda path: write_text(path, "x")])
@pytest.mark.parametrize("name", ["file/inside", "file/far/inside", "n" * 300])
def test_what_cannot_be_is_refused_by_name(
    tmp_path: Path, check: Callable[[Path], None], name: str
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match="cannot be written") as refused:
        check(tmp_path / name)
    assert refused.value.file == str(tmp_path / name)
    assert left(tmp_path) == ["file"]


def test_a_folder_is_no_file_and_a_file_no_folder(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="this is a folder"):
        check_file(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match="as this is not a folder"):
        check_folder(tmp_path / "file")


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no /proc here")
def test_a_place_where_no_file_can_be_is_refused_even_to_root() -> None:
    for check in (check_file, check_folder):
        with pytest.raises(DataError, match=r"/proc/new\.txt: cannot be written"):
            check("/proc/new.txt")


@NOT_ROOT
def test_what_is_write_protected_is_refused(tmp_path: Path) -> None:
    (tmp_path / "old.txt").touch(0o444)
    with pytest.raises(DataError, match=r"cannot be written \(Permission denied\)"):
        check_file(tmp_path / "old.txt")
    tmp_path.chmod(0o500)
    try:
        for check in (check_file, check_folder):
            with pytest.raises(DataError, match="cannot be written"):
                check(tmp_path / "new")
    finally:
        tmp_path.chmod(0o700)


def test_half_a_file_is_never_seen(tmp_path: Path) -> None:
    path = tmp_path / "numbers.csv"
    path.write_text("as before", encoding="utf-8")

    def fail(error: BaseException) -> None:
        with whole_file(path) as part:
            assert part.suffix == ".csv"
            part.write_text("half", encoding="utf-8")
            raise error

    with pytest.raises(DataError, match=r"numbers\.csv: cannot be written \(No space left"):
        fail(OSError(28, "No space left on device"))
    with pytest.raises(KeyboardInterrupt):
        fail(KeyboardInterrupt())
    assert left(tmp_path) == ["numbers.csv"]
    assert path.read_text(encoding="utf-8") == "as before"


@POSIX
def test_a_file_that_is_replaced_keeps_its_permissions_and_its_links(tmp_path: Path) -> None:
    path, link = tmp_path / "real.txt", tmp_path / "link.txt"
    path.touch()
    path.chmod(0o640)
    link.symlink_to(path)
    write_text(link, "new")
    assert link.is_symlink()
    assert path.read_text(encoding="utf-8") == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


@POSIX
def test_a_device_is_written_to_and_stays_one(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    check_file(pipe)  # without waiting for who reads it
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_text(pipe, "hello")
        assert os.read(reader, 10) == b"hello"
    finally:
        os.close(reader)
    assert pipe.is_fifo()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
def test_a_full_device_is_named() -> None:
    with pytest.raises(DataError, match=r"/dev/full: cannot be written \(No space left"):
        write_text("/dev/full", "x")
