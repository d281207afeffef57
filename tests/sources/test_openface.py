"""OpenFace's CSV against a head, eyes and a camera whose poses are known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from people import FloatArray, assert_one_sentence
from scipy.spatial.transform import Rotation
from shared_data import shared_file

from kendon.errors import DataError
from kendon.features import observe
from kendon.sources import CameraMount, OpenFaceSource, SourceOptions, open_source, read_openface

#: A camera that is off the axis, turned to the left and tilted down.
MOUNT = CameraMount((0.12, -0.05, 1.35), yaw=0.4, pitch=0.25)

Row = dict[str, float | str]


def camera_axes(mount: CameraMount) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Right, down and forward of the image in the robot's base frame."""
    ahead = np.array(
        [
            math.cos(mount.pitch) * math.cos(mount.yaw),
            math.cos(mount.pitch) * math.sin(mount.yaw),
            -math.sin(mount.pitch),
        ]
    )
    right = np.array([math.sin(mount.yaw), -math.cos(mount.yaw), 0.0])
    return right, np.cross(ahead, right), ahead


def to_base(x: float, y: float, z: float, mount: CameraMount = MOUNT) -> FloatArray:
    """A direction of OpenFace's camera frame in the base frame."""
    right, down, ahead = camera_axes(mount)
    return np.asarray(x * right + y * down + z * ahead)


def row(
    t: float = 0.0,
    position: tuple[float, float, float] = (0.0, 0.0, 2000.0),
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0),
    **more: float | str,
) -> Row:
    """A row of a face with both eyes open, 3 cm to either side of the nose."""
    cells: Row = {"frame": round(t * 30) + 1, "timestamp": t, "confidence": 0.98, "success": 1}
    for eye, (side, corners) in enumerate([(-1, (36, 39)), (1, (42, 45))]):
        # The person's left eye, OpenFace's eye 1, is on the right of the image.
        for k, corner in enumerate(corners):
            middle = position[0] + side * 30
            cells[f"X_{corner}"] = middle + (-14 if k == 0 else 14)
            cells[f"Y_{corner}"] = position[1] - 40
            cells[f"Z_{corner}"] = position[2] + (5 if k == 0 else -5)
        cells |= {f"gaze_{eye}_x": 0.1 * side, f"gaze_{eye}_y": 0.2, f"gaze_{eye}_z": -0.97}
    cells |= dict(zip(("pose_Tx", "pose_Ty", "pose_Tz"), position, strict=True))
    cells |= dict(zip(("pose_Rx", "pose_Ry", "pose_Rz"), turn, strict=True))
    cells |= {"AU06_r": 1.0, "AU12_r": 3.0, "AU12_c": 1.0}
    return cells | more


def write(path: Path, rows: list[Row], without: tuple[str, ...] = ()) -> Path:
    """As OpenFace writes it: a space after each comma of the header."""
    names = [n for n in rows[0] if not n.startswith(without)] if without else list(rows[0])
    lines = [", ".join(names), *(", ".join(str(r[n]) for n in names) for r in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def rows_at(rate: float, count: int = 30) -> list[Row]:
    return [row(i / rate) for i in range(count)]


# ---- where things are


@given(*[st.floats(-1.4, 1.4)] * 3)
def test_head_position_and_axes(
    tmp_path_factory: pytest.TempPathFactory, rx: float, ry: float, rz: float
) -> None:
    path = tmp_path_factory.getbasetemp() / "face.csv"
    write(path, [row(0, (300.0, -150.0, 1800.0), (rx, ry, rz)), row(0.1)])
    track = read_openface(path, MOUNT)
    expected = np.array(MOUNT.position) + to_base(0.3, -0.15, 1.8)
    np.testing.assert_allclose(track.head[0], expected, atol=1e-9)
    axes = Rotation.from_quat(track.head_rotation[0]).as_matrix()
    cx, sx, cy, sy = math.cos(rx), math.sin(rx), math.cos(ry), math.sin(ry)
    cz, sz = math.cos(rz), math.sin(rz)
    # R (0, 0, -1), out of the face, and R (1, 0, 0), to the person's left, for R = Rx Ry Rz.
    out = to_base(-sy, sx * cy, -cx * cy)
    left = to_base(cy * cz, cx * sz + sx * sy * cz, sx * sz - cx * sy * cz)
    np.testing.assert_allclose(axes[:, 0], out, atol=1e-9)
    np.testing.assert_allclose(axes[:, 1], left, atol=1e-9)
    np.testing.assert_allclose(axes[:, 2], np.cross(out, left), atol=1e-9)


def test_the_left_eye_is_eye_1(tmp_path: Path) -> None:
    path = write(tmp_path / "f.csv", [row(0, (300.0, -150.0, 1800.0)), row(0.1)])
    track = read_openface(path, MOUNT)
    for i, side in ((0, 1), (1, -1)):
        centre = np.array(MOUNT.position) + to_base(0.3 + side * 0.03, -0.19, 1.8)
        np.testing.assert_allclose(track.eyes[0, i], centre, atol=1e-9)
        np.testing.assert_allclose(track.eye_gaze[0, i], to_base(0.1 * side, 0.2, -0.97))


def test_the_default_camera_looks_ahead_from_1_2_metres(tmp_path: Path) -> None:
    path = write(tmp_path / "f.csv", [row(0, (-500.0, 100.0, 2500.0)), row(0.1)])
    track = read_openface(path)
    np.testing.assert_allclose(track.head[0], [2.5, 0.5, 1.1])
    axes = Rotation.from_quat(track.head_rotation[0]).as_matrix()
    np.testing.assert_allclose(axes, np.diag([-1, -1, 1]), atol=1e-12)  # faces the robot, upright


@pytest.mark.parametrize(
    ("turn", "toward"),
    [
        ((0.3, 0.0, 0.0), (-math.cos(0.3), 0.0, -math.sin(0.3))),  # +Rx: head down
        ((0.0, 0.3, 0.0), (-math.cos(0.3), math.sin(0.3), 0.0)),  # +Ry: to the image's left
        ((0.0, 0.0, 0.3), (-1.0, 0.0, 0.0)),  # Rz: tilts the head, looks the same way
    ],
)
def test_which_way_each_angle_turns(
    tmp_path: Path, turn: tuple[float, float, float], toward: tuple[float, float, float]
) -> None:
    track = read_openface(write(tmp_path / "f.csv", [row(0, turn=turn), row(0.1)]))
    out = Rotation.from_quat(track.head_rotation[0]).as_matrix()[:, 0]
    np.testing.assert_allclose(out, toward, atol=1e-12)


def test_observed_from_a_tilted_camera(tmp_path: Path) -> None:
    # One metre straight ahead of the camera, eyes on it, head turned 0.5 rad off it.
    rows = []
    for i in range(31):
        cells = row(i / 30, (0.0, 40.0, 1000.0), (0.0, 0.5, 0.0))
        for eye, side in ((0, -1), (1, 1)):
            cells |= {f"gaze_{eye}_x": -0.03 * side, f"gaze_{eye}_y": 0.0, f"gaze_{eye}_z": -1.0}
        rows.append(cells)
    track = read_openface(write(tmp_path / "f.csv", rows), MOUNT)
    seen = observe(track, MOUNT.position).values
    face = np.array(MOUNT.position) + to_base(0.0, 0.04, 1.0)
    np.testing.assert_allclose(seen[:, 0], math.hypot(face[0], face[1]))
    np.testing.assert_allclose(seen[:, 2], 0, atol=1e-9)
    np.testing.assert_allclose(seen[:, 3], 2.0)
    np.testing.assert_allclose(seen[1:, 1], 0, atol=1e-9)


# ---- what may be missing


def test_rows_without_success_are_unknown(tmp_path: Path) -> None:
    rows = rows_at(30)
    for i in range(10, 20):
        rows[i] = row(i / 30, (0.0, 0.0, 0.0), success=0)
    track = read_openface(write(tmp_path / "f.csv", rows))
    lost = np.arange(30) // 10 == 1
    for values in (track.head, track.head_rotation, track.eyes, track.eye_gaze, track.smile):
        assert np.isnan(values[lost]).all()
        assert np.isfinite(values[~lost]).all()
    assert np.isfinite(track.t).all()


@pytest.mark.parametrize(
    ("without", "field"),
    [
        ("AU06", "smile"),
        ("AU12_r", "smile"),
        ("pose_R", "head_rotation"),
        ("gaze_1", "eyes"),
        ("Z_4", "eye_gaze"),
        ("X_36", "eyes"),
    ],
)
def test_groups_that_openface_was_not_asked_for(tmp_path: Path, without: str, field: str) -> None:
    track = read_openface(write(tmp_path / "f.csv", rows_at(30), (without,)))
    assert np.isnan(getattr(track, field)).all()
    assert np.isfinite(track.head).all()
    assert len(observe(track)) == 4


def test_only_the_position_is_required(tmp_path: Path) -> None:
    rows: list[Row] = [
        {"timestamp": i / 30, "success": 1, "pose_Tx": 0, "pose_Ty": 0, "pose_Tz": 1500}
        for i in range(30)
    ]
    seen = observe(read_openface(write(tmp_path / "f.csv", rows)))
    np.testing.assert_allclose(seen.values[:, 0], 1.5)
    assert np.isnan(seen.values[:, 2:]).all()


def test_windows_nan_is_unknown(tmp_path: Path) -> None:
    rows = rows_at(30)
    rows[4] |= {"gaze_0_x": "-nan(ind)", "AU06_r": "nan"}
    track = read_openface(write(tmp_path / "f.csv", rows))
    assert np.isnan(track.eye_gaze[4, 1, 0]) or np.isnan(track.eye_gaze[4, 1]).any()
    assert np.isfinite(track.eye_gaze[4, 0]).all()
    assert np.isnan(track.smile[4])


def test_smile_is_the_mean_of_au06_and_au12_and_stays_within_5(tmp_path: Path) -> None:
    rows = [row(0), row(0.1, AU06_r=5.0, AU12_r=5.4), row(0.2, AU06_r=0.0, AU12_r=0.5)]
    np.testing.assert_allclose(read_openface(write(tmp_path / "f.csv", rows)).smile, [2, 5, 0.25])


# ---- several faces


def two_faces() -> list[Row]:
    """Face 3 in 20 frames, 1 m away; face 8 in 25, 2 m away, but with success in only 15."""
    rows = []
    for i in range(25):
        if i < 20:
            rows.append(row(i / 30, (0.0, 0.0, 1000.0), face_id=3))
        rows.append(row(i / 30, (0.0, 0.0, 2000.0), face_id=8, success=int(i < 15)))
    return rows


def test_the_face_seen_in_most_rows_is_read(tmp_path: Path) -> None:
    track = read_openface(write(tmp_path / "f.csv", two_faces()))
    assert len(track) == 20
    np.testing.assert_allclose(track.head[:, 0], 1.0)


def test_errors_name_the_row_of_the_file_not_of_the_face(tmp_path: Path) -> None:
    rows = two_faces()
    rows[6]["pose_Tx"] = "left"
    path = write(tmp_path / "f.csv", rows)
    with pytest.raises(DataError, match="'left' is not a number") as refused:
        read_openface(path)
    assert_one_sentence(refused.value, path, row=8, column="pose_Tx")


def test_no_face_at_all(tmp_path: Path) -> None:
    path = write(tmp_path / "f.csv", [row(i / 30, face_id=0, success=0) for i in range(9)])
    with pytest.raises(DataError, match="found no face in any row") as refused:
        read_openface(path)
    assert_one_sentence(refused.value, path, column="success")


# ---- stamps


def counted(path: Path, first: int = 1) -> Path:
    """What OpenFace makes of a folder of images: stamps that count, a millisecond each."""
    return write(path, [row(i / 1000, frame=first + i) for i in range(60)])


def test_counted_images_are_30_a_second_unless_told_otherwise(tmp_path: Path) -> None:
    path = counted(tmp_path / "images.csv")
    source = open_source(path)
    assert isinstance(source, OpenFaceSource)
    np.testing.assert_allclose(source.track.t, np.arange(60) / 30)
    (note,) = source.notes
    assert str(path) in note
    assert "30 frames a second" in note
    assert "--fps" in note
    told = open_source(path, SourceOptions(fps=12))
    assert isinstance(told, OpenFaceSource)
    np.testing.assert_allclose(told.track.t, np.arange(60) / 12)
    assert told.notes == ()


def test_fps_goes_before_the_files_stamps_and_counts_missing_frames(tmp_path: Path) -> None:
    rows = [r for i, r in enumerate(rows_at(30)) if not 5 <= i < 10]
    path = write(tmp_path / "f.csv", rows)
    track = read_openface(path, fps=15)
    np.testing.assert_allclose(track.t, np.r_[0:5, 10:30] / 15)
    without_numbers = read_openface(write(path, rows, ("frame",)), fps=15)
    np.testing.assert_allclose(without_numbers.t, np.arange(25) / 15)


def test_the_files_own_stamps_are_kept(tmp_path: Path) -> None:
    path = write(tmp_path / "f.csv", [row(0.04 * i + 3.2) for i in range(20)])
    source = OpenFaceSource.open(str(path), SourceOptions())
    np.testing.assert_allclose(source.track.t, 3.2 + 0.04 * np.arange(20))
    assert source.notes == ()


# ---- what is wrong

WRONG: dict[str, tuple[int, Row, int, str, str]] = {
    "100 m away": (4, {"pose_Tz": 100_001}, 6, "pose_Tz", "not between -100000 and 100000"),
    "an eye too far": (7, {"X_42": -2e5}, 9, "X_42", "not between"),
    "infinite angle": (3, {"pose_Rx": "inf"}, 5, "pose_Rx", "infinite"),
    "success 2": (1, {"success": 2}, 3, "success", "2 is not between 0 and 1"),
    "no number": (2, {"AU12_r": "high"}, 4, "AU12_r", "'high' is not a number"),
    "backward": (9, {"timestamp": 0.1}, 11, "timestamp", "0.1 s comes after"),
    "no stamp": (9, {"timestamp": ""}, 11, "timestamp", "the time is missing"),
}


@pytest.mark.parametrize(("at", "cells", "number", "column", "says"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_named_with_its_place(
    tmp_path: Path, at: int, cells: Row, number: int, column: str, says: str
) -> None:
    rows = rows_at(30)
    rows[at] |= cells
    path = write(tmp_path / "f.csv", rows)
    with pytest.raises(DataError) as refused:
        read_openface(path)
    assert_one_sentence(refused.value, path, row=number, column=column)
    assert says in str(refused.value)


def test_missing_columns_are_all_named(tmp_path: Path) -> None:
    path = write(tmp_path / "f.csv", rows_at(30), ("success", "pose_Ty"))
    with pytest.raises(DataError, match="columns success, pose_Ty missing") as refused:
        read_openface(path)
    assert_one_sentence(refused.value, path, row=1)


def test_frame_numbers_must_grow(tmp_path: Path) -> None:
    rows = rows_at(30)
    rows[12]["frame"] = 3
    path = write(tmp_path / "f.csv", rows)
    with pytest.raises(DataError, match="frame numbers do not grow") as refused:
        read_openface(path, fps=30)
    assert_one_sentence(refused.value, path, row=14, column="frame")


# ---- a real one


def test_a_real_file_is_read() -> None:
    path = shared_file("data/faces/openface_sample.csv")
    source = open_source(path)
    assert isinstance(source, OpenFaceSource)
    track = source.track
    assert len(track) == 100
    assert np.isfinite(track.head).all()
    distances = np.hypot(track.head[:, 0], track.head[:, 1])
    assert distances.min() > 0.2
    assert distances.max() < 3
    lengths = np.linalg.norm(track.eye_gaze, axis=-1)
    np.testing.assert_allclose(lengths, 1, atol=0.01)
    # The person's left eye is on the robot's right, 4 to 9 cm from the other one.
    assert (track.eyes[:, 0, 1] < track.eyes[:, 1, 1]).all()
    apart = np.linalg.norm(track.eyes[:, 0] - track.eyes[:, 1], axis=1)
    assert apart.min() > 0.04
    assert apart.max() < 0.09
    # Between the eyes and out of the face: the head's y axis runs from the right eye to the left.
    axes = Rotation.from_quat(track.head_rotation).as_matrix()
    toward_left = (track.eyes[:, 0] - track.eyes[:, 1]) / apart[:, None]
    assert (np.einsum("ni,ni->n", axes[:, :, 1], toward_left) > 0.95).all()
    assert len(observe(track)) > 5
