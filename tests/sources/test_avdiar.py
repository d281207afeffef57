"""AVDIAR: marks in images, depth from two rendered videos, and the thesis's own medians."""

from __future__ import annotations

import functools
import math
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from shared_data import shared_file

from kendon.errors import DataError, MissingExtraError, ParameterError
from kendon.features import distance, observe
from kendon.person import FloatArray, Track
from kendon.sources.avdiar import FACE_HEIGHT, AvdiarOptions, AvdiarSource, read_avdiar_pairs
from kendon.sources.avdiar_marks import FILE_JOINTS, read_marks
from kendon.sources.base import SourceOptions
from kendon.sources.thesis_observations import thesis_observations

WIDTH, HEIGHT, FOCAL, BASELINE = 360, 224, 260.0, 0.2
FRAMES = 11
FIRST = 5  # the number of the first marked frame
#: Where the two stand, left of the middle and right of it; x to the right, z ahead [m].
ASIDE = (-1.0, 0.7)
SPEED = 1.5  # [m/s], of person 1 toward person 2, along x


def row(frame: int, person: int, joints: dict[str, tuple[float, float]]) -> str:
    """A row of groundTruth.txt; joints that are not named are not seen."""
    cells = [joints.get(name, (-1, -1)) for name in FILE_JOINTS]
    return " ".join(str(v) for v in (frame, person, 0, *(round(c) for xy in cells for c in xy)))


def project(x: float, y: float, z: float) -> tuple[float, float]:
    return WIDTH / 2 + FOCAL * x / z, HEIGHT / 2 + FOCAL * y / z


def places(frame: int) -> list[tuple[float, float]]:
    """x and z [m] of both people; person 1 walks to the right."""
    return [(ASIDE[0] + SPEED * (frame - FIRST) / 25, 3.0), (ASIDE[1], 3.4)]


def marks(*, ankles: bool, frames: int = FRAMES) -> str:
    rows = []
    for frame in range(FIRST, FIRST + frames):
        for person, (x, z) in enumerate(places(frame), start=1):
            joints = {"nose": project(x, -0.1, z), "r_shoulder": project(x - 0.1, 0.2, z)}
            if ankles:
                joints["l_ankle"] = joints["r_ankle"] = project(x, 1.2, z)
            rows.append(row(frame, person, joints))
    return "\n".join(rows) + "\n"


@functools.cache
def _texture(seed: int) -> NDArray[np.uint8]:
    import cv2

    noise = np.random.default_rng(seed).integers(0, 256, (700, 1600)).astype(np.uint8)
    return np.asarray(cv2.GaussianBlur(noise, (0, 0), 1.2), dtype=np.uint8)


def draw(frame: int, camera: float) -> NDArray[np.uint8]:
    """The room from a camera `camera` metres to the right: a wall, two upright people."""
    import cv2

    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    image = np.zeros((HEIGHT, WIDTH), dtype=np.uint8)
    people = [(x, z, seed) for seed, (x, z) in enumerate(places(frame), start=1)]
    for x, z, seed in [(0.0, 4.5, 0), *sorted(people, key=lambda p: -p[1])]:
        across = (u - WIDTH / 2) * z / FOCAL + camera - x
        down = (v - HEIGHT / 2) * z / FOCAL
        column, line = (800 + 230 * across).astype("f4"), (350 + 230 * down).astype("f4")
        shade = cv2.remap(
            _texture(seed), column, line, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
        )
        inside = (np.abs(across) < 0.25) & (down > -0.35) if seed else np.ones_like(image, bool)
        image[inside] = shade[inside]
    return image


@pytest.fixture(scope="session")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sequence with both videos, a calibration, and marks without ankles."""
    cv2 = pytest.importorskip("cv2", reason="OpenCV is in the extra 'camera'")
    folder = tmp_path_factory.mktemp("avdiar") / "Scenario01-01"
    folder.mkdir()
    for side, camera in ((1, 0.0), (2, BASELINE)):
        writer = cv2.VideoWriter(
            str(folder / f"Scenario_CAM{side}.avi"),
            cv2.VideoWriter.fourcc(*"MJPG"), 25, (WIDTH, HEIGHT),
        )  # fmt: skip
        writer.set(cv2.VIDEOWRITER_PROP_QUALITY, 98)
        for frame in range(1, FIRST + FRAMES):
            writer.write(cv2.cvtColor(draw(max(frame, FIRST), camera), cv2.COLOR_GRAY2BGR))
        writer.release()
    K = np.array([[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]])
    np.savez(
        folder / "calibration.npz",
        K1=K, K2=K, D1=np.zeros(5), D2=np.zeros(5), R=np.eye(3),
        T=np.array([-1000 * BASELINE, 0, 0]), image_size=np.array([WIDTH, HEIGHT]),
    )  # fmt: skip
    (folder / "groundTruth.txt").write_text(marks(ankles=False))
    return folder


@pytest.fixture
def sequence(filmed: Path, tmp_path: Path) -> Path:
    """A copy of `filmed` that a test may change."""
    return Path(shutil.copytree(filmed, tmp_path / filmed.name))


def true_distance(track: Track) -> FloatArray:
    return np.array([math.dist(*places(FIRST + k)) for k in range(len(track))])


@pytest.fixture(scope="session")
def both(filmed: Path) -> list[Track]:
    return read_avdiar_pairs(filmed / "groundTruth.txt")


def test_distance_and_speed_come_out_of_the_two_videos(both: list[Track]) -> None:
    one, two = both
    assert (one.name, two.name) == ("Scenario01-01_p1_p2", "Scenario01-01_p2_p1")
    assert one.t[0] == pytest.approx((FIRST - 1) / 25)
    assert len(one) == FRAMES
    for track in (one, two):
        error = np.abs(distance(track.head) - true_distance(track))
        assert np.isfinite(error).mean() > 0.95
        assert np.nanmedian(error) < 0.03
        assert np.nanmax(error) < 0.15
    walks, stands = (observe(track).values for track in (one, two))
    assert np.nanmedian(walks[:, 1]) == pytest.approx(1.42, abs=0.15)
    assert np.nanmedian(stands[:, 1]) == pytest.approx(0.0, abs=0.1)
    assert np.isnan(walks[:, 2]).all()


def test_both_greetings_see_the_same_distance_straight_ahead(both: list[Track]) -> None:
    one, two = both
    seen = np.isfinite(one.head[:, 0])
    assert distance(one.head)[seen] == pytest.approx(distance(two.head)[seen])
    assert one.head[seen, 1] == pytest.approx(0, abs=1e-9)
    # Person 1 is 1.7 m to the left of person 2 and 0.4 m nearer to the camera.
    assert math.degrees(one.robot[0, 2]) == pytest.approx(103, abs=3)


def test_without_ankles_the_height_is_assumed_and_noted(filmed: Path) -> None:
    source = AvdiarSource.open(f"{filmed}/groundTruth.txt", SourceOptions())
    assert any(f"faces are taken to be {FACE_HEIGHT:g} m" in note for note in source.notes)
    assert any("taken to be rectified already" in note for note in source.notes)
    track = source.record()
    assert np.nanmedian(track.head[:, 2]) == pytest.approx(FACE_HEIGHT, abs=0.02)
    told = read_avdiar_pairs(filmed / "groundTruth.txt", AvdiarOptions(camera_height=1.5))[0]
    assert np.nanmedian(told.head[:, 2]) == pytest.approx(1.6, abs=0.02)
    shoulder = told.joints["r_shoulder"]
    assert np.nanmedian(shoulder[:, 2]) == pytest.approx(1.3, abs=0.03)
    assert "l_wrist" not in told.joints


def test_the_floor_is_where_ankles_are(sequence: Path) -> None:
    (sequence / "groundTruth.txt").write_text(marks(ankles=True))
    source = AvdiarSource.open(f"{sequence}/groundTruth.txt", SourceOptions())
    assert not any("floor is unknown" in note for note in source.notes)
    # Ankles at y = 1.2 m below the camera's axis, the nose 0.1 m above it.
    track = source.record()
    assert np.nanmedian(track.head[:, 2]) == pytest.approx(1.3, abs=0.05)


def test_the_spec_picks_the_pair_and_frames_come_from_it(filmed: Path) -> None:
    assert AvdiarSource.recognises(f"{filmed}/groundTruth.txt#2-1")
    assert AvdiarSource.recognises("GroundTruth/face_bb.txt")
    assert not AvdiarSource.recognises("skeletons.txt")
    source = AvdiarSource.open(f"{filmed}/groundTruth.txt#2", SourceOptions())
    seen: list[float] = []
    track = source.record(lambda frame: seen.append(frame.t))
    assert seen == track.t.tolist()
    assert track.name.endswith("p2_p1")
    assert next(source.frames()).t == track.t[0]


def test_face_boxes_of_the_original_release_are_read(sequence: Path) -> None:
    """GroundTruth/face_bb.txt with Video/*_CAM?.avi, the calibration one folder up."""
    boxes = []
    for frame in range(FIRST, FIRST + FRAMES):
        for person, (x, z) in enumerate(places(frame), start=1):
            u, v = project(x, -0.1, z)
            boxes.append(f"{frame},{person},{u - 10:.1f},{v - 12:.1f},20,24")
    home = sequence / "Seq01"
    for folder in ("GroundTruth", "Video"):
        (home / folder).mkdir(parents=True)
    (home / "GroundTruth" / "face_bb.txt").write_text("\n".join(boxes))
    for side in "12":
        name = f"Scenario_CAM{side}.avi"
        (sequence / name).rename(home / "Video" / name)
    one, _ = read_avdiar_pairs(home / "GroundTruth" / "face_bb.txt")
    assert one.name == "Seq01_p1_p2"
    assert np.nanmedian(np.abs(distance(one.head) - true_distance(one))) < 0.03
    assert one.joints == {}


def test_a_face_box_whose_place_is_unknown_is_not_in_the_corner(tmp_path: Path) -> None:
    path = tmp_path / "face_bb.txt"
    path.write_text("1,1,nan,30,20,24\n1,2,50,60,20,24\n2,1,-15,30,20,24\n2,2,50,60,20,24\n")
    one = read_marks(path).people[1][:, FILE_JOINTS.index("nose")]
    assert np.isnan(one[0, 0])
    assert one[0, 1] == 42
    assert one[1].tolist() == [0, 42]  # past the rim, where half a face still shows


def test_marks_at_another_size_are_scaled(sequence: Path) -> None:
    path = sequence / "groundTruth.txt"
    rows = [line.split() for line in path.read_text().splitlines()]
    doubled = [[*r[:3], *(v if v == "-1" else str(2 * int(v)) for v in r[3:])] for r in rows]
    path.write_text("\n".join(" ".join(r) for r in doubled))
    with pytest.raises(DataError, match=r"lies outside the images of 360 x 224 pixels"):
        read_avdiar_pairs(path)
    options = AvdiarOptions(marked_size=(2 * WIDTH, 2 * HEIGHT))
    one, _ = read_avdiar_pairs(path, options)
    assert np.nanmedian(np.abs(distance(one.head) - true_distance(one))) < 0.03
    with pytest.raises(DataError, match="were marked, the videos have 360 x 224, which is another"):
        read_avdiar_pairs(path, AvdiarOptions(marked_size=(720, 720)))


def test_rectifying_a_straight_pair_changes_nothing(filmed: Path) -> None:
    one, _ = read_avdiar_pairs(filmed / "groundTruth.txt", AvdiarOptions(rectify=True))
    assert np.nanmedian(np.abs(distance(one.head) - true_distance(one))) < 0.03


def test_a_pair_that_is_not_rectified_is_doubted(sequence: Path) -> None:
    import cv2

    right = sequence / "Scenario_CAM2.avi"
    writer = cv2.VideoWriter(str(right), cv2.VideoWriter.fourcc(*"MJPG"), 25, (WIDTH, HEIGHT))
    image = np.roll(draw(FIRST, BASELINE), 6, axis=0)
    for _ in range(FIRST + FRAMES):
        writer.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    writer.release()
    source = AvdiarSource.open(f"{sequence}/groundTruth.txt", SourceOptions())
    assert any("rows apart in the two images" in note for note in source.notes)


def test_another_frame_rate_is_noted(filmed: Path) -> None:
    source = AvdiarSource.open(f"{filmed}/groundTruth.txt", SourceOptions(fps=30))
    assert any("claims 25.00 frames a second; read at 30" in note for note in source.notes)
    assert np.diff(source.record().t) == pytest.approx(1 / 30)


@pytest.mark.parametrize(
    ("missing", "message"),
    [
        (("Scenario_CAM1.avi",), r"missing beside them: the left camera's video"),
        (("Scenario_CAM2.avi",), r"missing beside them: the right camera's video"),
        (("calibration.npz",), r"missing beside them: the stereo calibration"),
        (
            ("Scenario_CAM1.avi", "Scenario_CAM2.avi", "calibration.npz"),
            r"groundTruth\.txt: marks in images have no depth by themselves; missing beside them:"
            r" the left .*, the right .*, the stereo",
        ),
    ],
)
def test_missing_files_are_named_in_one_sentence(
    sequence: Path, missing: tuple[str, ...], message: str
) -> None:
    for name in missing:
        (sequence / name).unlink()
    with pytest.raises(DataError, match=message):
        AvdiarSource.open(f"{sequence}/groundTruth.txt", SourceOptions())


def test_files_may_be_named_and_several_are_refused(sequence: Path) -> None:
    path = sequence / "groundTruth.txt"
    shutil.copy(sequence / "calibration.npz", sequence / "calibration2.npz")
    with pytest.raises(DataError, match=r"several calibrations lie here \(calibration\.npz, cal"):
        read_avdiar_pairs(path)
    options = AvdiarOptions(calibration=sequence / "calibration2.npz")
    assert len(read_avdiar_pairs(path, options)) == 2


def test_a_video_that_ends_early_is_named(sequence: Path) -> None:
    path = sequence / "groundTruth.txt"
    path.write_text(marks(ankles=False, frames=FRAMES + 5))
    with pytest.raises(DataError, match=r"CAM1\.avi: the video ends before frame 16"):
        read_avdiar_pairs(path)


def test_frames_before_the_first_are_refused(sequence: Path) -> None:
    with pytest.raises(DataError, match="frame 5 lies before the video's first, 6"):
        read_avdiar_pairs(sequence / "groundTruth.txt", AvdiarOptions(first_frame=6))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fps": 0.0}, "fps must be positive"),
        ({"nearest": math.nan}, "nearest must be positive"),
        ({"camera_height": -1.0}, "camera_height must be positive"),
        ({"marked_size": (0, 450)}, "marked_size must be positive"),
    ],
)
def test_impossible_options_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        AvdiarOptions(**change)


def test_without_opencv_the_extra_is_named(filmed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(MissingExtraError, match=r"kendon\[camera\]"):
        AvdiarSource.open(f"{filmed}/groundTruth.txt", SourceOptions())


def test_marks_are_read_by_their_joints(tmp_path: Path) -> None:
    path = tmp_path / "groundTruth.txt"
    path.write_text(
        "\n".join(
            [
                row(3, 1, {"nose": (10, 20), "l_ear": (14, 18)}),
                row(3, 1, {"nose": (99, 99)}),  # twice: the first counts
                row(5, 1, {"r_eye": (8, 16), "l_eye": (12, 18)}),
                row(6, 1, {"r_ear": (7, 17)}),
                row(6, 4, {"neck": (50, 60)}),
            ]
        )
    )
    found = read_marks(path)
    assert found.frames.tolist() == [3, 4, 5, 6]
    assert sorted(found.people) == [1, 4]
    faces = found.faces(1)
    assert faces[[0, 2, 3]].tolist() == [[10, 20], [10, 17], [7, 17]]
    assert np.isnan(faces[1]).all()
    assert np.isnan(found.faces(4)).all()
    assert found.extent == (50, 60)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("groundTruth.txt", "", "the file is empty"),
        ("groundTruth.txt", "1 1 0 5 5", r"row 1: torn row: 5 numbers where there should be 39"),
        ("groundTruth.txt", row(1, 1, {}), "nobody is marked anywhere"),
        ("groundTruth.txt", "x" + row(1, 1, {"nose": (1, 1)}), "'x1', number 1 of the row"),
        ("groundTruth.txt", row(1, 1, {"nose": (1, -5)}), "-5 is no pixel of an image"),
        ("groundTruth.txt", row(1, 1, {"nose": (1, 10**6)}), "1e.06 is no pixel of an image"),
        ("groundTruth.txt", "0.5" + row(1, 1, {})[1:], r"row 1, column 'frame': the frame is a"),
        ("groundTruth.txt", "1 -2 0" + row(1, 1, {})[5:], "column 'person': the person is a count"),
        ("groundTruth.txt", "1 1 7" + row(1, 1, {})[5:], "column 'speaking': speaking is 0 or 1"),
        ("groundTruth.txt", row(10**7, 1, {}), "the frame is a count, not 1e.07"),
        ("face_bb.txt", "1,1,5,5,10,10\n2,1,5,5,10", "row 2: torn row: 5 numbers"),
        ("face_bb.txt", "1,1,5,5,0,10", "a face of 0 x 10 pixels is none"),
        ("face_bb.txt", "1,1,5,5,10,inf", "row 1: number 6 of the row is infinite"),
    ],
)
def test_bad_marks_are_named(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(DataError, match=message):
        read_marks(path)


def test_people_who_are_never_marked_together_are_no_pair(sequence: Path) -> None:
    path = sequence / "groundTruth.txt"
    path.write_text(row(1, 1, {"nose": (10, 20)}) + "\n" + row(2, 2, {"nose": (30, 20)}) + "\n")
    with pytest.raises(DataError, match="no two people are ever marked in the same frame"):
        read_avdiar_pairs(path)
    with pytest.raises(DataError, match="there is no person 9; valid: 1, 2"):
        AvdiarSource.open(f"{path}#9", SourceOptions())


def test_a_real_track_of_joints() -> None:
    path = shared_file("data/avdiar/Scenario01-02/groundTruth.txt")
    found = read_marks(path)
    assert (found.frames[0], found.frames[-1], len(found.frames)) == (49, 694, 646)
    assert list(found.people) == [1]
    assert set(found.speaking[1].tolist()) == {0.0, 1.0}
    x, y = found.extent
    assert x < 720
    assert y <= 450
    assert np.isfinite(found.faces(1)).all()
    marks = found.people[1]
    eyes, ears = (
        marks[:, [FILE_JOINTS.index(f"r_{part}"), FILE_JOINTS.index(f"l_{part}")]]
        for part in ("eye", "ear")
    )
    # Eyes lie nearer to the nose than ears: the order of the file, not the README's.
    nose = marks[:, :1]
    to_eyes = np.linalg.norm(eyes - nose, axis=2)
    to_ears = np.linalg.norm(ears - nose, axis=2)
    assert np.nanmedian(to_eyes) < 0.7 * np.nanmedian(to_ears)


def test_a_real_track_of_one_person_is_no_greeting() -> None:
    path = shared_file("data/avdiar/Scenario01-02/groundTruth.txt")
    with pytest.raises(DataError, match="a greeting needs two people; there is only 1"):
        AvdiarSource.open(str(path), SourceOptions())


# The thesis's own medians (3.5.1), against numbers worked out by hand.


def line(distances: list[float]) -> Track:
    """A person straight ahead of a robot that stands still, at 25 frames a second."""
    head = np.array([[d, 0.0, 1.5] for d in distances])
    return Track.build(np.arange(len(head)) / 25, head)


def test_medians_of_groups_of_five_begin_at_a_tenth_of_a_second() -> None:
    #              first  group 1: 3.9 is the median      group 2
    track = line([4.0, 4.0, 3.9, 9.0, 3.8, 3.8, 3.7, 3.6, 3.6, 3.5, 3.4])
    seen = thesis_observations(track)
    assert seen.t == pytest.approx([0.1, 0.3])
    assert seen.values[:, 0] == pytest.approx([3.9, 3.6])
    # Steps of group 1: 0, 0.1, -5.1, 5.2, 0; of group 2: 0.1, 0.1, 0, 0.1, 0.1; over 1/25 s.
    assert seen.values[:, 1] == pytest.approx([0.0, 2.5])
    assert np.isnan(seen.values[:, 2]).all()


def test_an_outlying_group_is_interpolated_and_its_speed_follows() -> None:
    distances = [4.0] + [4.0] * 5 + [3.8] * 5 + [7.0] * 5 + [3.4] * 5 + [3.2] * 5 + [3.0] * 5
    seen = thesis_observations(line(distances))
    assert seen.values[:, 0] == pytest.approx([4.0, 3.8, 3.6, 3.4, 3.2, 3.0])
    assert seen.values[2, 1] == pytest.approx((3.8 - 3.6) / 0.2)
    # Within a group nothing moves: the median of the frame speeds is 0 elsewhere.
    assert np.delete(seen.values[:, 1], 2) == pytest.approx(0)


def test_a_steady_approach_has_no_outliers_and_unknown_groups_stay_unknown() -> None:
    walk = [5.0 - 0.06 * k for k in range(46)]
    seen = thesis_observations(line(walk))
    assert seen.values[:, 0] == pytest.approx([5.0 - 0.06 * (5 * k + 3) for k in range(9)])
    assert seen.values[:, 1] == pytest.approx(1.5)
    walk[6:11] = [math.nan] * 5
    gap = thesis_observations(line(walk))
    assert np.isnan(gap.values[1, :2]).all()
    assert gap.values[[0, 2], 0] == pytest.approx([4.82, 4.22])
