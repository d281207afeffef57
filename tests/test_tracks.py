"""The track CSV: a round trip, real recordings, and everything a file can have wrong."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from people import assert_one_sentence, tracks
from shared_data import shared_file, shared_files

from kendon.errors import DataError
from kendon.features import observe
from kendon.person import JOINTS, Track
from kendon.tables import is_index, peek_header, read_table, write_table
from kendon.tracks import read_track, write_track

#: Rows of a file, the header first.
Rows = list[list[str]]


def text(rows: Rows) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def good() -> Rows:
    """Twenty frames at 10 Hz, every group of columns there is."""
    header = ["t", "head_x", "head_y", "head_z", "head_qx", "head_qy", "head_qz", "head_qw"]
    header += [f"l_wrist_{axis}" for axis in "xyz"]
    header += [
        f"{side}_{what}_{axis}" for what in ("eye", "gaze") for side in "lr" for axis in "xyz"
    ]
    header += ["smile", "dsal", "csal", "hdip", "robot_x", "robot_y", "robot_yaw", "phase"]
    rows = [header]
    for i in range(20):
        row = [f"{i / 10}", f"{4 - i / 10}", "0.1", "1.6", "0", "0", "1", "0"]
        row += ["3.5", "0.2", "1.1"]
        row += ["3.9", "-0.03", "1.6", "3.9", "0.03", "1.6", "-1", "0", "0", "-1", "0", "0"]
        row += ["2.5", "1", "0", "0.5", "0.1", "0.2", "3.1", "DS"]
        rows.append(row)
    return rows


def put(column: str, row: int, value: str) -> Callable[[Rows], None]:
    """Change one cell; rows as an editor counts them."""

    def change(rows: Rows) -> None:
        rows[row - 1][rows[0].index(column)] = value

    return change


def scale(column: str, factor: float) -> Callable[[Rows], None]:
    def change(rows: Rows) -> None:
        place = rows[0].index(column)
        for row in rows[1:]:
            row[place] = str(float(row[place]) * factor)

    return change


def rename(column: str, name: str) -> Callable[[Rows], None]:
    def change(rows: Rows) -> None:
        rows[0][rows[0].index(column)] = name

    return change


def drop(*columns: str) -> Callable[[Rows], None]:
    def change(rows: Rows) -> None:
        for column in columns:
            place = rows[0].index(column)
            for row in rows:
                del row[place]

    return change


def shift(first: int, seconds: float) -> Callable[[Rows], None]:
    """Add to the stamps from a row on."""

    def change(rows: Rows) -> None:
        for row in rows[first - 1 :]:
            row[0] = f"{float(row[0]) + seconds:g}"

    return change


def cut(row: int, length: int, *more: str) -> Callable[[Rows], None]:
    def change(rows: Rows) -> None:
        rows[row - 1][length:] = more

    return change


def written(path: Path, *changes: Callable[[Rows], None]) -> Path:
    rows = good()
    for change in changes:
        change(rows)
    path.write_text(text(rows), encoding="utf-8")
    return path


# ---- what is right


def test_a_whole_track_is_read(tmp_path: Path) -> None:
    track = read_track(written(tmp_path / "person.csv"))
    assert (track.name, len(track)) == ("person", 20)
    frame = list(track)[3]
    assert frame.t == 0.3
    assert frame.head == (3.7, 0.1, 1.6)
    assert frame.head_rotation == (0, 0, 1, 0)
    assert frame.eyes == ((3.9, -0.03, 1.6), (3.9, 0.03, 1.6))
    assert frame.eye_gaze == ((-1, 0, 0), (-1, 0, 0))
    assert frame.joints == {"l_wrist": (3.5, 0.2, 1.1)}
    assert (frame.smile, frame.dsal, frame.csal, frame.hdip) == (2.5, 1, 0, 0.5)
    assert frame.robot == (0.1, 0.2, 3.1)
    assert track.phases is not None
    assert set(track.phases.tolist()) == {2}


def test_only_time_and_head_are_required(tmp_path: Path) -> None:
    path = tmp_path / "bare.csv"
    path.write_text("t,head_x,head_y,head_z\n0,1,2,3\n0.1,,,\n", encoding="utf-8")
    track = read_track(path)
    np.testing.assert_array_equal(track.head, [[1, 2, 3], [np.nan] * 3])
    assert track.joints == {}
    assert track.phases is None
    np.testing.assert_array_equal(track.robot, 0)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.replace("\n", "\r\n"),
        lambda s: "\ufeff" + s,
        lambda s: s.replace(",", ", "),
        lambda s: s.replace("\n", "\n\n"),
        lambda s: s.rstrip("\n"),
        lambda s: s.replace("t,head_x", '"t","head_x"'),
        lambda s: s.replace("DS", " ds "),
        lambda s: s.replace(",phase", ",l_knee_x").replace(",DS", ",0.4"),
    ],
    ids=["crlf", "bom", "spaces", "blank-rows", "no-end", "quotes", "lower-case", "other-joint"],
)
def test_the_ways_of_writing_csv_do_not_matter(
    tmp_path: Path, change: Callable[[str], str]
) -> None:
    path = tmp_path / "person.csv"
    path.write_bytes(change(text(good())).encode())
    track = read_track(path)
    assert len(track) == 20
    np.testing.assert_allclose(track.head[:, 0], 4 - np.arange(20) / 10)
    assert peek_header(path)[:2] == ("t", "head_x")


def test_phases_are_words_none_or_nothing(tmp_path: Path) -> None:
    words = ["IA", "DS", "HD", "APP", "FA", "CS", "NONE", ""]
    changes = [put("phase", row, word) for row, word in enumerate(words, start=2)]
    track = read_track(written(tmp_path / "p.csv", *changes))
    assert track.phases is not None
    assert track.phases[:8].tolist() == [1, 2, 3, 4, 5, 6, 0, -1]


@pytest.mark.parametrize("word", ["", "nan", "NaN", "NA", "null", "None", " ", "-nan(ind)"])
def test_the_words_for_unknown(tmp_path: Path, word: str) -> None:
    track = read_track(written(tmp_path / "p.csv", put("smile", 4, word)))
    assert np.flatnonzero(np.isnan(track.smile)).tolist() == [2]


def test_a_rounded_quaternion_is_made_a_unit_one(tmp_path: Path) -> None:
    changes = [put("head_qz", 5, "0.71"), put("head_qw", 5, "0.71"), put("head_qx", 6, "")]
    rotation = read_track(written(tmp_path / "p.csv", *changes)).head_rotation
    np.testing.assert_allclose(rotation[3], [0, 0, math.sqrt(0.5), math.sqrt(0.5)])
    assert np.isnan(rotation[4]).all()  # unknown in part is unknown


@settings(max_examples=50)
@given(tracks())
def test_a_written_track_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, track: Track
) -> None:
    assume(np.median(np.diff(track.t)) < 0.4)  # a file with fewer frames a second is refused
    path = tmp_path_factory.getbasetemp() / "again.csv"
    write_track(track, path)
    again = read_track(path)
    for field in ("t", "head", "head_rotation", "smile", "gestures", "robot", "eyes"):
        np.testing.assert_allclose(getattr(again, field), getattr(track, field), atol=2e-6)
    np.testing.assert_array_equal(again.phases, track.phases)
    if np.isfinite(track.joints["r_wrist"]).any():
        np.testing.assert_allclose(again.joints["r_wrist"], track.joints["r_wrist"], atol=2e-6)
    if np.isfinite(track.eyes).any():
        np.testing.assert_allclose(again.eye_gaze, track.eye_gaze, atol=2e-6)


def test_clock_times_survive_to_the_microsecond(tmp_path: Path) -> None:
    t = 1_700_000_000.123456 + np.arange(30) / 30
    path = tmp_path / "clock.csv"
    write_track(Track.build(t, np.ones((30, 3))), path)
    np.testing.assert_allclose(read_track(path).t, t, rtol=0, atol=1e-6)


def test_columns_of_which_nothing_is_known_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "sub" / "folder" / "bare.csv"
    write_track(Track.build(np.array([0.0, 0.1]), np.array([[1.5, np.nan, 0], [1, 2, 3]])), path)
    assert path.read_text(encoding="utf-8") == "t,head_x,head_y,head_z\n0,1.5,,0\n0.1,1,2,3\n"


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "kept.csv"
    path.write_text("before", encoding="utf-8")

    def rows_that_break() -> object:
        yield [1.0]
        raise RuntimeError("power cut")

    with pytest.raises(RuntimeError, match="power cut"):
        write_table(path, ["t"], rows_that_break())  # type: ignore[arg-type]
    assert path.read_text(encoding="utf-8") == "before"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name != "posix", reason="only POSIX systems have a umask")
def test_a_file_gets_the_permissions_the_umask_leaves_and_the_umask_stays(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_table(tmp_path / "new.csv", ["t"], [[0.0]])
        assert os.umask(0o027) == 0o027
    finally:
        os.umask(before)
    assert (tmp_path / "new.csv").stat().st_mode & 0o777 == 0o640


def test_the_umask_of_the_process_is_never_touched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(mask: int) -> int:
        raise AssertionError("another thread would create its files with this mask")

    monkeypatch.setattr(os, "umask", refuse)
    write_table(tmp_path / "new.csv", ["t"], [[0.0]])
    assert [path.name for path in tmp_path.iterdir()] == ["new.csv"]


def test_a_place_that_cannot_be_written_to_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"cannot be written") as refused:
        write_table(tmp_path, ["t"], [[1.0]])
    assert_one_sentence(refused.value, tmp_path)
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(DataError, match=r"cannot be written"):
        write_table(file / "inside.csv", ["t"], [[1.0]])


# ---- what is wrong

NO_FILE: dict[str, tuple[bytes | None, str]] = {
    "missing file": (None, "there is no such file"),
    "empty": (b"", "the file is empty"),
    "header only": (b"t,head_x,head_y,head_z\n", "a header but no rows"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR\xff\xd8", "no text at all"),
    "zeros": (b"\x00" * 4096, "no rows"),
    "latin-1": ("t,head_x,head_y,head_z,gr\xfc\xdfe\n".encode("latin-1"), "UTF-8"),
    "utf-16": ("t,head_x,head_y,head_z\n0,1,2,3\n".encode("utf-16"), "UTF-8"),
    "latin-1 far down": (
        b"t,head_x,head_y,head_z\n" + b"".join(b"%d,1,1,1\n" % i for i in range(9999)) + b"\xfc\n",
        "UTF-8",
    ),
    "one giant cell": (b"t,head_x\n" + b"9" * 200_000 + b",1\n", "not a readable CSV"),
    "semicolons": (b"t;head_x;head_y;head_z\n0;1;2;3\n", "t, head_x, head_y, head_z missing"),
    "prose": (b"Dear reader\nthis is a letter\n", "missing; the file has Dear reader"),
    "json": (b'{"frames": [' + b"1 " * 30_000 + b"]}\n1\n", "missing"),
}


@pytest.mark.parametrize(("content", "says"), NO_FILE.values(), ids=NO_FILE)
def test_what_is_no_track_file(tmp_path: Path, content: bytes | None, says: str) -> None:
    path = tmp_path / "person.csv"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(DataError) as refused:
        read_track(path)
    assert_one_sentence(refused.value, path)
    assert says in str(refused.value)


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="this is a folder, not a file") as refused:
        read_track(tmp_path)
    assert_one_sentence(refused.value, tmp_path)


Wrong = tuple[Callable[[Rows], None], int | None, str | None, str]
WRONG: dict[str, Wrong] = {
    "torn short": (cut(8, 30), 8, None, "torn row: 30 cells where the header has 31"),
    "torn long": (cut(8, 31, "1"), 8, None, "32 cells where the header has 31"),
    "column twice": (rename("l_wrist_x", "head_x"), 1, None, "head_x stands more than once"),
    "no time": (rename("t", "seconds"), 1, None, "column t missing"),
    "no head": (drop("head_x", "head_y", "head_z"), 1, None, "head_x, head_y, head_z missing"),
    "half a head": (drop("head_z"), 1, None, "column head_z missing"),
    "misspelt smile": (rename("smile", "smille"), 1, None, "did you mean 'smile'"),
    "misspelt gesture": (rename("dsal", "dsl"), 1, None, "did you mean 'dsal'"),
    "capital phase": (rename("phase", "Phase"), 1, None, "did you mean 'phase'"),
    "misspelt joint": (rename("l_wrist_y", "l_wirst_y"), 1, None, "did you mean 'l_wrist_y'"),
    "half a quaternion": (drop("head_qx", "head_qw"), 1, None, "head_qx, head_qw missing"),
    "half a joint": (drop("l_wrist_z"), 1, None, "l_wrist_z missing"),
    "half a robot pose": (drop("robot_yaw"), 1, None, "robot_yaw missing"),
    "eyes without gaze": (drop(*good()[0][17:23]), 1, None, "l_gaze_x"),
    "word": (put("head_y", 9, "left"), 9, "head_y", "'left' is not a number"),
    "decimal comma": (put("head_y", 9, "1,5"), 9, "head_y", "'1,5' is not a number"),
    "long word": (put("smile", 3, "ha" * 500), 3, "smile", "is not a number"),
    "inf": (put("head_x", 4, "inf"), 4, "head_x", "infinite"),
    "minus inf": (put("robot_x", 4, "-inf"), 4, "robot_x", "infinite"),
    "too large for a float": (put("head_x", 4, "1e999"), 4, "head_x", "infinite"),
    "time missing": (put("t", 6, ""), 6, "t", "the time is missing"),
    "time NaN": (put("t", 2, "nan"), 2, "t", "the time is missing"),
    "time inf": (put("t", 21, "inf"), 21, "t", "infinite"),
    "unsorted": (put("t", 10, "0.15"), 10, "t", "0.15 s comes after 0.7 s"),
    "time twice": (put("t", 10, "0.7"), 10, "t", "0.7 s stands twice"),
    "millimetres": (scale("head_x", 1000), 2, "head_x", "are these millimetres"),
    "a joint in millimetres": (scale("l_wrist_z", 1000), 2, "l_wrist_z", "are these millimetres"),
    "milliseconds": (scale("t", 1000), 3, "t", "are these milliseconds"),
    "a frame a second": (scale("t", 10), 3, "t", "at least 2 frames a second"),
    "huge gap": (shift(12, 3600), 12, "t", "nothing for 3600 s before this row"),
    "smile 7": (put("smile", 5, "7"), 5, "smile", "7 is not between 0 and 5"),
    "smile -1": (put("smile", 5, "-1"), 5, "smile", "-1 is not between 0 and 5"),
    "probability 1.2": (put("csal", 7, "1.2"), 7, "csal", "1.2 is not between 0 and 1"),
    "robot yaw in degrees": (put("robot_yaw", 7, "90"), 7, "robot_yaw", "are these degrees"),
    "quaternion too long": (put("head_qx", 11, "1"), 11, "head_qx", "length 1.41 instead of 1"),
    "quaternion of zeros": (put("head_qz", 11, "0"), 11, "head_qw", "length 0.00 instead of 1"),
    "quaternion of angles": (put("head_qz", 11, "3.1"), 11, "head_qz", "not between"),
    "unknown phase": (put("phase", 13, "HUG"), 13, "phase", "'HUG' is no phase; valid: IA, DS"),
    "phase number 9": (put("phase", 13, "9"), 13, "phase", "'9' is no phase"),
}  # fmt: skip


@pytest.mark.parametrize(("change", "row", "column", "says"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_named_with_its_place(
    tmp_path: Path, change: Callable[[Rows], None], row: int | None, column: str | None, says: str
) -> None:
    path = written(tmp_path / "person.csv", change)
    with pytest.raises(DataError) as refused:
        read_track(path)
    assert_one_sentence(refused.value, path, row=row, column=column)
    assert (refused.value.file, refused.value.row) == (str(path), row)
    assert says in str(refused.value)


def test_blank_rows_and_cells_of_several_lines_do_not_shift_the_count(tmp_path: Path) -> None:
    rows = text(good()).splitlines()
    rows[3] = rows[3].replace("DS", '"\nDS"')  # rows 4 and 5 of the file
    path = tmp_path / "person.csv"
    path.write_text("\n".join([*rows[:2], "", "", *rows[2:6], rows[6].replace("DS", "X")]))
    with pytest.raises(DataError, match="'X' is no phase") as refused:
        read_track(path)
    assert refused.value.row == 7 + 2 + 1


@pytest.mark.parametrize("joint", ["knee", "ankle", "heel", "eyebrow", "ear", "hand", "shin"])
def test_other_parts_of_the_body_are_not_taken_for_misspelt(tmp_path: Path, joint: str) -> None:
    path = tmp_path / "p.csv"
    columns = [f"{side}_{joint}_{axis}" for side in "lr" for axis in "xyz"]
    rows = [["t", "head_x", "head_y", "head_z", *columns], ["0"] * 10, ["0.1"] * 10]
    path.write_text(text(rows), encoding="utf-8")
    assert read_track(path).joints == {}


def test_an_index_of_recordings_is_told_from_a_recording(tmp_path: Path) -> None:
    index = tmp_path / "index.csv"
    index.write_text("file,kind\na.csv,wave\n", encoding="utf-8")
    assert is_index(index)
    assert not is_index(written(tmp_path / "person.csv"))
    assert not is_index(tmp_path)
    assert not is_index(tmp_path / "absent.csv")


def test_a_table_tells_what_columns_it_has(tmp_path: Path) -> None:
    table = read_table(written(tmp_path / "person.csv"))
    assert "smile" in table
    assert "laugh" not in table
    assert table.texts("phase") == ["DS"] * 20
    with pytest.raises(DataError, match="columns laugh, frown missing; the file has t, head_x"):
        table.require("smile", "laugh", "frown")


# ---- real recordings


def test_every_recorded_greeting_is_read_and_observed() -> None:
    paths = shared_files("data/mocap/greeting_*.csv") + shared_files("data/mocap/passerby_*.csv")
    assert len(paths) == 32
    for path in paths:
        track = read_track(path)
        assert set(track.joints) == set(JOINTS)
        seen = observe(track)
        assert seen.phases is not None
        ways, speeds = seen.values[:, 0], seen.values[1:, 1]
        assert np.isfinite(ways).all()
        assert 0.5 < ways.min() < ways.max() < 10
        assert np.abs(speeds).max() < 2  # nobody runs
        if path.name.startswith("passerby"):
            assert set(seen.phases.tolist()) == {0}
            assert ways.min() < ways[0]
            assert ways[-1] > 4
        else:
            assert {1, 6} <= set(seen.phases.tolist()) <= {1, 2, 3, 4, 5, 6}
            assert ways[-1] < 1.5 < ways[0]
            assert np.median(speeds[np.abs(speeds) > 0.3]) > 0.5


def test_people_recorded_beside_a_partner_are_read() -> None:
    for path in shared_files("data/gestures/*.csv"):
        assert len(observe(read_track(path))) > 5


def test_the_index_of_the_recordings_is_no_recording() -> None:
    assert is_index(shared_file("data/mocap/index.csv"))
