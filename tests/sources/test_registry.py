"""Which source reads what, and what is said when none does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from people import assert_one_sentence

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.person import PersonFrame, Track
from kendon.sources import (
    CameraMount,
    OpenFaceSource,
    Source,
    SourceOptions,
    TrackSource,
    open_source,
    registered_sources,
)
from kendon.sources.base import find_source
from kendon.tracks import write_track


@pytest.fixture
def track_file(tmp_path: Path) -> Path:
    path = tmp_path / "person.csv"
    phases = np.array([1, 2, 3, 6] * 5)
    write_track(Track.build(np.arange(20) / 10, np.ones((20, 3)), phases=phases), path)
    return path


def test_every_source_says_what_it_is() -> None:
    sources = registered_sources()
    assert {"track", "openface"} <= set(sources)
    for name, source in sources.items():
        assert source.name == name
        assert source.reads
        assert source.example


def test_the_register_cannot_be_changed_from_outside() -> None:
    registered_sources().clear()
    assert registered_sources()


def test_a_track_csv_is_recognised_by_its_columns(track_file: Path) -> None:
    source = open_source(track_file)
    assert isinstance(source, TrackSource)
    frames = list(source.frames())
    assert len(frames) == 20
    assert frames[3].t == pytest.approx(0.3)
    assert source.record() is source.track
    renamed = track_file.rename(track_file.with_suffix(".CSV"))
    assert isinstance(open_source(str(renamed)), TrackSource)


def test_openface_is_recognised_by_its_columns(tmp_path: Path) -> None:
    path = tmp_path / "face.csv"
    path.write_text("frame, timestamp, success, pose_Tx\n", encoding="utf-8")
    assert find_source(path) is OpenFaceSource


@pytest.mark.parametrize(
    ("first", "why"),
    [
        (b"", "it is empty"),
        (b'"', "the file has a header but no rows"),
        (b"t;head_x\n", "its cells are separated by semicolons, where kendon reads commas"),
        (b"t;head_x\n0;1,5\n", "its cells are separated by semicolons, where kendon reads commas"),
        (b"a,b,c\n1,2,3\n", "its columns are a, b, c"),
        (b"a,b,c\n1,2\n", "row 2: torn row: 2 cells where the header has 3"),
        ("t,head_x,phase\n0,1,Jäger\n".encode("latin-1"), "this is no CSV file in UTF-8"),
        ("t,head_x\n0,1\n".encode("utf-16"), "this is no CSV file in UTF-8"),
    ],
)
def test_another_csv_is_not_recognised(tmp_path: Path, first: bytes, why: str) -> None:
    path = tmp_path / "other.csv"
    path.write_bytes(first)
    with pytest.raises(DataError, match=f"no source recognises this file: {why}") as refused:
        open_source(path)
    assert_one_sentence(refused.value, path)
    assert all(name in str(refused.value) for name in registered_sources())


def test_a_kind_of_file_nobody_reads(tmp_path: Path) -> None:
    path = tmp_path / "thesis.pdf"
    path.write_bytes(b"%PDF-1.4\xff")
    with pytest.raises(DataError, match="no source recognises this file; there are") as refused:
        open_source(path)
    assert_one_sentence(refused.value, path)


def test_what_does_not_exist(tmp_path: Path) -> None:
    path = tmp_path / "nowhere.csv"
    with pytest.raises(DataError, match="there is no such file") as refused:
        open_source(path)
    assert_one_sentence(refused.value, path)
    with pytest.raises(DataError, match="there is no such file"):
        open_source(path, name="track")


def test_a_folder(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"this is a folder.*DIR/\*\.csv") as refused:
        open_source(tmp_path)
    assert_one_sentence(refused.value, tmp_path)


def test_an_unknown_source_is_answered_with_the_known_ones(track_file: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"there is no source 'kinect'; valid: .*track"):
        open_source(track_file, name="kinect")
    with pytest.raises(UnknownNameError, match="did you mean 'track'"):
        open_source(track_file, name="trak")


def test_a_named_source_reads_the_file_whatever_it_looks_like(track_file: Path) -> None:
    with pytest.raises(DataError, match="pose_Tx") as refused:
        open_source(track_file, name="openface")
    assert_one_sentence(refused.value, track_file, row=1)
    other = track_file.rename(track_file.with_suffix(".txt"))
    assert isinstance(open_source(other, name="track"), TrackSource)


def test_a_recording_with_keys_pressed_by_its_phases(track_file: Path) -> None:
    source = open_source(track_file)
    assert isinstance(source, TrackSource)
    pressed = source.with_gestures_from_phases()
    assert [f.dsal for f in pressed.frames()][:4] == [0, 1, 0, 0]
    assert [f.csal for f in pressed.frames()][:4] == [0, 0, 0, 1]
    assert all(math.isnan(f.dsal) for f in source.frames()), "the recording itself is unchanged"


def test_a_source_without_a_whole_recording_can_be_recorded() -> None:
    class Passing(Source):
        name = "passing"
        reads = "nothing"
        example = "passing"

        @classmethod
        def recognises(cls, spec: str) -> bool:
            return False

        @classmethod
        def open(cls, spec: str, options: SourceOptions) -> Source:
            return cls()

        def frames(self) -> Iterator[PersonFrame]:
            for i in range(4):
                yield PersonFrame(i / 10, (4.0 - i, 0.0, 1.6))

    seen: list[float] = []
    track = Passing().record(lambda frame: seen.append(frame.t))
    assert seen == track.t.tolist()
    np.testing.assert_array_equal(track.head[:, 0], [4, 3, 2, 1])
    assert "passing" not in registered_sources(), "only @register makes a source known"


@pytest.mark.parametrize("fps", [0.0, -30.0, 0.5, 1e6, math.nan, math.inf])
def test_frames_a_second_are_in_range(fps: float) -> None:
    with pytest.raises(ParameterError, match="frames a second lie between 1 and 1000"):
        SourceOptions(fps=fps)


@pytest.mark.parametrize(
    "mount", [{"position": (0.0, math.nan, 1.0)}, {"yaw": math.inf}, {"pitch": math.nan}]
)
def test_a_camera_mount_is_finite(mount: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match="finite numbers"):
        CameraMount(**mount)  # type: ignore[arg-type]
