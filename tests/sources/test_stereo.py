"""Depth from two cameras: rendered rooms of known depth, calibration files, and what is refused."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.person import FloatArray
from kendon.sources.stereo import StereoRig, StereoVideo, depth_map, point_at, row_offset
from kendon.sources.stereo_calibration import StereoCalibration, read_stereo_calibration

cv2: Any = pytest.importorskip("cv2", reason="OpenCV is in the extra 'camera'")

ByteImage = NDArray[np.uint8]
SIZE = (480, 300)
BASELINE = 0.2  # [m], as in AVDIAR
K = np.array([[400.0, 0, 239.5], [0, 400.0, 149.5], [0, 0, 1]])
WALL, PERSON = 4.0, 2.5  # [m]
#: The person-like patch: x from left to right, y from top to bottom [m].
PATCH = (-0.5, 0.1, -0.6, 0.9)


def look(R: FloatArray, T: FloatArray, *, D: FloatArray | None = None) -> ByteImage:
    """A wall and a person-like patch before it, seen by a camera at x_camera = R x_world + T."""
    rng = np.random.default_rng(7)
    textures = [
        cv2.GaussianBlur(rng.integers(0, 256, (1400, 1400)).astype(np.uint8), (0, 0), 1.0)
        for _ in range(2)
    ]
    pixels = np.stack(np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1])), axis=-1)
    flat = pixels.reshape(-1, 1, 2).astype(float)
    rays = cv2.undistortPoints(flat, K, np.zeros(5) if D is None else D).reshape(-1, 2)
    rays = np.column_stack([rays, np.ones(len(rays))]) @ R  # R^T on rows
    origin = -R.T @ T
    image = np.zeros(len(rays), dtype=np.uint8)
    for depth, texture, bounds in (
        (WALL, textures[0], None),
        (PERSON, textures[1], PATCH),
    ):
        x, y = (origin + rays * ((depth - origin[2]) / rays[:, 2])[:, None]).T[:2]
        # About one texel a pixel at that depth.
        place = 700 + np.stack([x, y]) * K[0, 0] / depth * 0.8
        u, v = place.reshape(2, SIZE[1], SIZE[0]).astype(np.float32)
        shade = cv2.remap(texture, u, v, cv2.INTER_LINEAR).ravel()
        inside = np.ones(len(x), dtype=bool)
        if bounds:
            inside = (x > bounds[0]) & (x < bounds[1]) & (y > bounds[2]) & (y < bounds[3])
        image[inside] = shade[inside]
    return image.reshape(SIZE[1], SIZE[0])


@functools.cache
def straight_pair() -> tuple[ByteImage, ByteImage]:
    return look(np.eye(3), np.zeros(3)), look(np.eye(3), np.array([-BASELINE, 0, 0]))


def q(unit: float = 1.0) -> FloatArray:
    return np.array(
        [
            [1, 0, 0, -K[0, 2]],
            [0, 1, 0, -K[1, 2]],
            [0, 0, 0, K[0, 0]],
            [0, 0, unit / BASELINE, 0],
        ]
    )


def pixel_of(point: tuple[float, float, float]) -> tuple[float, float]:
    x, y, w = K @ np.array(point)
    return float(x / w), float(y / w)


@pytest.mark.parametrize(("unit", "factor"), [("m", 1.0), ("mm", 0.001), ("cm", 0.01)])
def test_planes_of_known_depth_are_recovered_within_two_percent(unit: str, factor: float) -> None:
    points = depth_map(*straight_pair(), q(factor), unit=unit)
    assert points.shape == (SIZE[1], SIZE[0], 3)
    for place in ((-0.2, 0.0, PERSON), (1.2, -0.5, WALL), (0.9, 0.8, WALL), (-1.5, 0.3, WALL)):
        found = point_at(points, pixel_of(place))
        assert found == pytest.approx(place, abs=0.02 * place[2])


def test_nearly_everything_has_a_depth_and_most_of_it_is_right() -> None:
    depth = depth_map(*straight_pair(), q())[:, :, 2]
    assert np.isfinite(depth).mean() > 0.8
    known = depth[np.isfinite(depth)]
    off = np.minimum(np.abs(known - WALL) / WALL, np.abs(known - PERSON) / PERSON)
    assert (off < 0.02).mean() > 0.95


def test_the_left_rim_is_matched_too() -> None:
    depth = depth_map(*straight_pair(), q())[:, :, 2]
    # A wall 4 m away has a disparity of 20 pixels; without a margin 112 columns would be lost.
    assert np.isfinite(depth[:, 25:100]).mean() > 0.8


def test_the_nearest_depth_bounds_what_is_looked_for() -> None:
    depth = depth_map(*straight_pair(), q(), nearest=3.2)[:, :, 2]
    assert np.nanmin(depth) >= 3.2
    x, y = pixel_of((1.2, -0.5, WALL))
    assert depth[round(y), round(x)] == pytest.approx(WALL, rel=0.02)


def test_colour_images_have_the_depth_of_grey_ones() -> None:
    left, right = straight_pair()
    grey = depth_map(left, right, q())
    left, right = (cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) for image in (left, right))
    colour = depth_map(left, right, q())
    assert np.nanmedian(np.abs(grey - colour)) < 1e-3


def test_a_turned_and_distorted_pair_is_rectified() -> None:
    R = cv2.Rodrigues(np.array([0.02, -0.03, 0.015]))[0]
    T = R @ np.array([-BASELINE, 0.004, 0.002])
    D = np.array([-0.15, 0.05, 0.001, -0.001, 0.0])
    left, right = look(np.eye(3), np.zeros(3), D=D), look(R, T, D=D)
    calibration = StereoCalibration(Path("c.yml"), SIZE, K, D, K, D, R, T)
    rig = StereoRig(calibration, SIZE, rectify=True)
    assert row_offset(left, right) > 2
    assert row_offset(*rig.images(left, right)) < 1
    points = rig.depth(left, right)
    for place in ((-0.2, 0.0, PERSON), (0.9, -0.5, WALL)):
        seen, _ = cv2.projectPoints(np.array([place]), np.zeros(3), np.zeros(3), K, D)
        (pixel,) = rig.pixels(seen.reshape(1, 2))
        found = point_at(points, (pixel[0], pixel[1]))
        # Rectifying turns the camera: lengths stay, single coordinates do not.
        assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(place), rel=0.02)


def test_a_rectified_pair_needs_no_maps() -> None:
    calibration = StereoCalibration(
        Path("c.yml"), SIZE, K1=K, K2=K, T=np.array([-BASELINE, 0, 0]), rectified=True
    )
    rig = StereoRig(calibration, SIZE, rectify=False)
    assert pytest.approx(q()) == rig.Q
    left, right = straight_pair()
    assert rig.images(left, right) == (left, right)
    marks = np.array([[1.0, 2.0], [math.nan, math.nan]])
    assert rig.pixels(marks) is marks
    assert row_offset(left, right) < 1


def test_a_calibration_at_another_size_is_scaled() -> None:
    # The same cameras at half the size; pixel 0 becomes the middle of old pixels 0 and 1.
    half = StereoCalibration(
        Path("c.yml"),
        (SIZE[0] // 2, SIZE[1] // 2),
        K1=np.array([[200.0, 0, 119.5], [0, 200.0, 74.5], [0, 0, 1]]),
        K2=np.array([[200.0, 0, 119.5], [0, 200.0, 74.5], [0, 0, 1]]),
        T=np.array([-BASELINE, 0, 0]),
    )
    assert pytest.approx(K) == half.scaled(SIZE).K1
    assert half.scaled(SIZE).disparity_to_depth() == pytest.approx(q())
    given = StereoCalibration(Path("c.yml"), half.size, Q=half.disparity_to_depth())
    assert pytest.approx(q()) == given.scaled(SIZE).Q
    assert given.scaled(half.size) is given
    with pytest.raises(DataError, match=r"480 x 480, which is another shape: it was cropped"):
        half.scaled((480, 480))


@pytest.mark.parametrize("pixel", [(math.nan, 3.0), (-1.0, 3.0), (3.0, 1e6), (math.nan, math.nan)])
def test_a_pixel_outside_has_no_point(pixel: tuple[float, float]) -> None:
    assert np.isnan(point_at(np.ones((10, 10, 3)), pixel)).all()


def test_a_point_is_the_median_of_enough_known_neighbours() -> None:
    points = np.full((9, 9, 3), math.nan)
    points[2:5, 2:5] = [0.1, 0.2, 3.0]
    points[2, 2] = [5, 5, 9]
    assert point_at(points, (4, 4)) == (0.1, 0.2, 3.0)
    assert np.isnan(point_at(points, (4, 4), least=10)).all()
    assert point_at(np.ones((10, 10, 3)), (-0.4, 9.4)) == (1, 1, 1)


def test_images_without_corners_have_no_row_offset() -> None:
    blank: ByteImage = np.zeros((100, 100), dtype=np.uint8)
    assert math.isnan(row_offset(blank, blank))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"unit": "inch"}, "no unit of length 'inch'; valid: mm, cm, m"),
        ({"nearest": 0.0}, "smallest depth must be positive"),
    ],
)
def test_depth_refuses_what_cannot_be(change: dict[str, Any], message: str) -> None:
    with pytest.raises((ParameterError, UnknownNameError), match=message):
        depth_map(*straight_pair(), q(), **change)


def test_images_of_two_sizes_are_no_pair() -> None:
    left, right = straight_pair()
    with pytest.raises(ParameterError, match="must have one size"):
        depth_map(left, right[:200], q())


def write_storage(path: Path, **values: Any) -> Path:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for key, value in values.items():
        storage.write(key, value)
    storage.release()
    return path


def values(**change: Any) -> dict[str, Any]:
    known = {
        "K1": K, "D1": np.zeros(5), "K2": K, "D2": np.zeros((1, 5)), "R": np.eye(3),
        "T": np.array([[-200.0], [0], [0]]), "image_size": np.array(SIZE),
    }  # fmt: skip
    return {key: value for key, value in {**known, **change}.items() if value is not None}


@pytest.mark.parametrize("suffix", [".yml", ".yaml", ".xml", ".npz"])
def test_calibrations_are_read_from_opencv_and_numpy(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"calibration{suffix}"
    if suffix == ".npz":
        np.savez(path, **values())
    else:
        write_storage(path, **values())
    found = read_stereo_calibration(path)
    assert found.size == SIZE
    assert pytest.approx(K) == found.K1
    assert pytest.approx([-0.2, 0, 0]) == found.T  # millimetres unless told otherwise
    assert found.rectified is None
    assert found.Q is None


def test_a_file_may_tell_unit_size_and_rectification(tmp_path: Path) -> None:
    path = write_storage(
        tmp_path / "c.yml",
        **values(image_size=None, T=np.array([-0.2, 0, 0]), K1=None, M1=K),
        width=480, height=300, unit="m", rectified=1, Q=q(),
    )  # fmt: skip
    found = read_stereo_calibration(path)
    assert (found.size, found.rectified) == (SIZE, True)
    assert pytest.approx([-0.2, 0, 0]) == found.T
    assert pytest.approx(q()) == found.Q
    assert pytest.approx(K) == found.K1


def test_sequences_written_by_hand_are_read(tmp_path: Path) -> None:
    path = tmp_path / "c.yml"
    path.write_text("%YAML:1.0\n---\nimage_size: [480, 300]\nT: [-20., 0., 0.]\nunit: cm\n")
    assert pytest.approx([-0.2, 0, 0]) == read_stereo_calibration(path).T


def test_the_unit_told_by_the_caller_wins(tmp_path: Path) -> None:
    path = tmp_path / "c.npz"
    np.savez(path, **values(Q=q(), T=None, unit="mm"))
    assert pytest.approx(q()) == read_stereo_calibration(path, unit="m").Q
    with pytest.raises(UnknownNameError, match="no unit of length 'km'"):
        read_stereo_calibration(path, unit="km")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"T": np.array([-0.2, 0, 0])}, r"c\.npz: the cameras would be 0\.0002 m apart, read in"),
        ({"Q": q(), "T": None}, r"the cameras would be 0\.0002 m apart, read in mm"),
        ({"Q": np.eye(4) * [[1], [1], [1], [0]]}, "Q knows no distance between the cameras"),
        ({"K1": np.eye(4)}, r"column 'K1': the shape must be \(3, 3\), not \(4, 4\)"),
        ({"T": np.zeros(2)}, r"column 'T': the shape must be \(3,\)"),
        ({"D1": np.zeros(3)}, "3 distortion coefficients; OpenCV knows 4, 5, 8, 12 or 14"),
        ({"R": 2 * np.eye(3)}, "column 'R': this is no rotation"),
        ({"K2": -K}, "column 'K2': the focal lengths must be positive"),
        ({"K2": K * math.nan}, "column 'K2': a number is not finite"),
        ({"R": np.array("north")}, "column 'R': this is no array of numbers"),
        ({"image_size": None}, "image_size .* is missing"),
        ({"image_size": np.array([0, 300])}, "image_size .* missing or none"),
    ],
)
def test_a_wrong_calibration_is_refused(
    tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    path = tmp_path / "c.npz"
    np.savez(path, **values(**change))
    with pytest.raises(DataError, match=message):
        read_stereo_calibration(path)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("c.yml", "K1: [1", "OpenCV cannot read this calibration"),
        ("c.yml", "%YAML:1.0\n---\nK1: !!opencv-matrix\n  rows: 3\n", "OpenCV cannot read"),
        ("c.yml", "", "OpenCV cannot read"),
        ("c.xml", "<a>", "OpenCV cannot read"),
        ("c.npz", "PK", "no NPZ file of arrays, or it is torn"),
    ],
)
def test_a_torn_calibration_is_refused(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(DataError, match=message):
        read_stereo_calibration(path)
    with pytest.raises(DataError, match="there is no such file"):
        read_stereo_calibration(tmp_path / "none.yml")


def test_a_rig_says_what_its_calibration_lacks() -> None:
    bare = StereoCalibration(Path("c.yml"), SIZE)
    with pytest.raises(DataError, match=r"c\.yml: K1, K2, R, T missing"):
        StereoRig(bare, SIZE, rectify=True)
    with pytest.raises(DataError, match="neither Q nor K1, K2 and T"):
        StereoRig(bare, SIZE, rectify=False)
    above = StereoCalibration(
        Path("c.yml"), SIZE, K, None, K, None, np.eye(3), np.array([0, -0.2, 0])
    )
    with pytest.raises(DataError, match="T does not point along the image rows"):
        StereoRig(above, SIZE, rectify=False)
    with pytest.raises(DataError, match="stand above each other"):
        StereoRig(above, SIZE, rectify=True)


def test_videos_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    paths = []
    for name, size in (("a.avi", (64, 48)), ("b.avi", (96, 48)), ("c.avi", (64, 48))):
        paths.append(tmp_path / name)
        writer = cv2.VideoWriter(str(paths[-1]), cv2.VideoWriter.fourcc(*"MJPG"), 25, size)
        for _ in range(3):
            writer.write(np.zeros((size[1], size[0], 3), dtype=np.uint8))
        writer.release()
    with pytest.raises(DataError, match=r"b\.avi: 96 x 48 pixels, but a\.avi has 64 x 48"):
        StereoVideo(paths[0], paths[1])
    with pytest.raises(DataError, match=r"d\.avi: there is no such video"):
        StereoVideo(paths[0], tmp_path / "d.avi")
    video = StereoVideo(paths[0], paths[2])
    assert [number for number, _, _ in video.frames([0, 2])] == [0, 2]
    with pytest.raises(DataError, match="ends before frame 6"):
        list(video.frames([1, 5]))
    (tmp_path / "e.avi").write_text("no video")
    with pytest.raises(DataError, match=r"e\.avi: this is no video that OpenCV can read"):
        StereoVideo(paths[0], tmp_path / "e.avi")
