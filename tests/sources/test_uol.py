"""UoL: Kinect skeletons of two people, gaze by changing frames, and the thesis's own averages."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.features import distance, observe
from kendon.geometry import ORIGIN, Pose2D
from kendon.person import FloatArray, Track
from kendon.sources.base import SourceOptions
from kendon.sources.kinect_skeletons import FILE_JOINTS, read_kinect_skeletons
from kendon.sources.pairs import Body, greeting, split_spec
from kendon.sources.thesis_observations import thesis_observations
from kendon.sources.uol import UolOptions, UolSource, read_uol, read_uol_pairs

RATE = 15.0
FLOOR = -0.8  # [m], below the camera
#: World axes (ahead of the camera, to its left, up) as rows, in the Kinect's x left, y up, z ahead.
KINECT = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
#: kendon's head axes (out of the face, left, up) in a joint's frame (z out of the face, y up).
FACE = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
BODY = {
    "SpineBase": (0, 0, 0.9), "SpineMid": (0, 0, 1.2), "SpineShoulder": (0, 0, 1.4),
    "Neck": (0, 0, 1.45), "Head": (0, 0, 1.6), "Foot": (0.1, 0.1, 0), "Ankle": (0, 0.1, 0.1),
    "Knee": (0, 0.1, 0.5), "Hip": (0, 0.1, 0.9), "Shoulder": (0, 0.2, 1.4),
    "Elbow": (0, 0.25, 1.1), "Wrist": (0.2, 0.25, 1.0), "Hand": (0.25, 0.25, 1.0),
    "HandTip": (0.3, 0.25, 1.0), "Thumb": (0.25, 0.2, 1.0),
}  # fmt: skip


def person(
    places: FloatArray,
    heading: float,
    *,
    look: float | None = None,
    on: str = "Neck",
    axes: FloatArray = KINECT,
) -> FloatArray:
    """Somebody at places (T, 2) in the world, (T, 25, 7) in the camera's frame.

    Args:
        places: on the ground, ahead of the camera and to its left [m].
        heading: of the body [rad].
        look: of the head [rad]; the body's by default.
        on: the joint that carries the head's orientation; the others have zeros.
        axes: the world's axes in the camera's frame.
    """
    result = np.zeros((len(places), 25, 7))
    c, s = math.cos(heading), math.sin(heading)
    for i, name in enumerate(FILE_JOINTS):
        side = 1 if name.endswith("Left") else -1
        ahead, aside, up = BODY[name.removesuffix("Left").removesuffix("Right")]
        world = np.column_stack(
            [
                places[:, 0] + c * ahead - s * side * aside,
                places[:, 1] + s * ahead + c * side * aside,
                np.full(len(places), up + FLOOR),
            ]
        )
        result[:, i, :3] = world @ axes
    turned = Rotation.from_euler("z", heading if look is None else look).as_matrix()
    quaternion = Rotation.from_matrix(axes.T @ turned @ FACE.T).as_quat()
    result[:, FILE_JOINTS.index(on), 3:] = quaternion
    return result


def write(
    path: Path, slots: list[FloatArray | None], t: FloatArray | None = None, *, start: float = 5e8
) -> Path:
    """A file of slots; None is an empty one, NaN an absence. Times count from `start`."""
    frames = len(next(s for s in slots if s is not None))
    t = np.arange(frames) / RATE if t is None else t
    lines = []
    for k in range(frames):
        cells = [f"{start + t[k]:.4f}"]
        for number, slot in enumerate(slots):
            if slot is None or np.isnan(slot[k]).any():
                cells.append("")
            else:
                cells.append(f"7205759{number} " + " ".join(f"{v:.6f}" for v in slot[k].ravel()))
        lines.append(",".join(cells))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")
    return path


def meeting(frames: int = 46, **change: Any) -> list[FloatArray | None]:
    """Person 1 walks 1 m/s from y = 4.5 m toward person 2 at y = 0, both 3 m from the camera."""
    t = np.arange(frames) / RATE
    walk = np.column_stack([np.full(frames, 3.0), 4.5 - t])
    stand = np.column_stack([np.full(frames, 3.0), 1e-5 * np.sin(t)])
    return [person(walk, -math.pi / 2, **change), person(stand, math.pi / 2, **change)]


@pytest.fixture
def skeletons(tmp_path: Path) -> Path:
    return write(tmp_path / "recording_1482159915" / "skeletons.txt", meeting())


def test_both_greetings_have_the_distance_and_their_own_speed(skeletons: Path) -> None:
    walker, stander = read_uol_pairs(skeletons)
    assert (walker.name, stander.name) == (
        "recording_1482159915_p1_p2",
        "recording_1482159915_p2_p1",
    )
    for track, speed in ((walker, 1.0), (stander, 0.0)):
        assert track.duration == pytest.approx(3.0, abs=1e-3)
        assert distance(track.head) == pytest.approx(4.5 - track.t, abs=1e-3)
        assert observe(track).values[1:, 1] == pytest.approx(speed, abs=0.02)
        assert track.head[:, 2] == pytest.approx(1.6, abs=1e-4)
        assert track.head[:, 1] == pytest.approx(0, abs=1e-3)
        # Face to face, the person's right is on the robot's left.
        assert track.joints["r_shoulder"][0, 1] == pytest.approx(0.2, abs=1e-3)


def test_people_who_look_at_each_other_have_gaze_zero(skeletons: Path) -> None:
    found = read_uol(skeletons)
    assert found.robot_face == pytest.approx((0, 0, 1.6), abs=1e-3)
    gaze = observe(found.track, found.robot_face).values[:, 2]
    assert gaze == pytest.approx(0, abs=1e-3)
    assert any("0.00,0.00,1.60" in note for note in found.notes)


@given(st.floats(-25, 25))
def test_gaze_is_the_angle_past_the_partner(degrees: float) -> None:
    """A look turned by an angle passes the partner by tan of it; the ray is 1 / cos longer."""
    look = -math.pi / 2 + math.radians(degrees)
    two = meeting(8)[1]
    walk = np.column_stack([np.full(8, 3.0), np.full(8, 4.0)])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "skeletons.txt"
        write(path, [person(walk, -math.pi / 2, look=look), two])
        found = read_uol(path)
    expected = math.tan(abs(math.radians(degrees))) * math.cos(math.radians(degrees))
    gaze = observe(found.track, found.robot_face).values[:, 2]
    assert gaze == pytest.approx(expected / math.tan(math.pi / 6), abs=2e-3)


def test_the_heads_own_orientation_comes_before_the_necks(tmp_path: Path) -> None:
    path = write(tmp_path / "skeletons.txt", meeting(on="Head"))
    found = read_uol(path)
    assert not any("neck" in note for note in found.notes)
    assert observe(found.track, found.robot_face).values[:, 2] == pytest.approx(0, abs=1e-3)
    path = write(tmp_path / "skeletons.txt", meeting(on="Neck"))
    assert any("head orientation is the neck's" in note for note in read_uol(path).notes)


def test_without_any_orientation_gaze_is_unknown_and_a_note_says_so(tmp_path: Path) -> None:
    path = write(tmp_path / "skeletons.txt", meeting(on="SpineBase"))
    found = read_uol(path)
    assert np.isnan(observe(found.track).values[:, 2]).all()
    assert any("Person 1's head has no orientation" in note for note in found.notes)


@pytest.mark.parametrize(
    ("vertical", "axes"),
    [
        ("y", KINECT),
        ("-y", KINECT * [-1, -1, 1]),  # a camera on its head
        ("z", np.eye(3)),
        ("-x", np.array([[0.0, 1, 0], [0, 0, -1], [-1, 0, 0]])),
    ],
)
def test_the_vertical_is_the_axis_from_foot_to_head(
    tmp_path: Path, vertical: str, axes: FloatArray
) -> None:
    assert np.linalg.det(axes) == pytest.approx(1)
    path = write(tmp_path / "skeletons.txt", meeting(axes=axes))
    found = read_uol(path)
    assert any(f"Up is taken to be {vertical}," in note for note in found.notes)
    assert distance(found.track.head) == pytest.approx(4.5 - found.track.t, abs=1e-3)
    assert found.track.joints["r_shoulder"][0, 1] == pytest.approx(0.2, abs=1e-3)
    assert observe(found.track, found.robot_face).values[:, 2] == pytest.approx(0, abs=1e-3)
    told = read_uol(path, UolOptions(vertical=vertical))
    assert told.track.head == pytest.approx(found.track.head)
    assert not any("Up is taken" in note for note in told.notes)


def test_a_lying_axis_is_doubted(tmp_path: Path) -> None:
    tilt = Rotation.from_euler("x", 40, degrees=True).as_matrix()
    path = write(tmp_path / "skeletons.txt", meeting(axes=KINECT @ tilt))
    assert any("but hardly so" in note for note in read_uol(path).notes)


def test_faces_that_look_past_each_other_are_doubted(tmp_path: Path) -> None:
    path = write(tmp_path / "skeletons.txt", meeting())
    assert not any("face_axis" in n or "mirror" in n for n in read_uol(path).notes)
    wrong = read_uol(path, UolOptions(face_axis="x"))
    (note,) = [n for n in wrong.notes if "face_axis" in n]
    assert "90 degrees past each other in the median, but only 0 if faces are turned by" in note


def test_people_back_to_back_are_doubted_and_can_be_mirrored(tmp_path: Path) -> None:
    slots = [s for s in meeting() if s is not None]
    swap = [
        FILE_JOINTS.index(n.replace("Left", "*").replace("Right", "Left").replace("*", "Right"))
        for n in FILE_JOINTS
    ]
    path = write(tmp_path / "skeletons.txt", [s[:, swap] for s in slots])
    assert any("mirror image" in note for note in read_uol(path).notes)
    found = read_uol(path, UolOptions(mirrored=True))
    assert not any("mirror image" in note for note in found.notes)
    assert found.track.joints["r_shoulder"][0, 1] == pytest.approx(0.2, abs=1e-3)


def test_an_absence_is_unknown_and_the_robots_pose_is_not(tmp_path: Path) -> None:
    one, two = meeting()
    assert one is not None
    assert two is not None
    one[10:20], two[30:35] = math.nan, math.nan
    track = read_uol(write(tmp_path / "skeletons.txt", [one, None, two])).track
    unknown = np.isnan(track.head).any(axis=1)
    assert np.flatnonzero(unknown).tolist() == [*range(10, 20), *range(30, 35)]
    assert np.isfinite(track.robot).all()
    assert track.robot[32, :2] == pytest.approx([3, 0], abs=1e-3)


def test_the_spec_names_person_and_partner(skeletons: Path) -> None:
    def name(suffix: str) -> str:
        return UolSource.open(f"{skeletons}{suffix}", SourceOptions()).track.name[-5:]

    assert [name(s) for s in ("", "#1", "#2", "#1-2", "#2-1")] == [
        "p1_p2", "p1_p2", "p2_p1", "p1_p2", "p2_p1",
    ]  # fmt: skip
    assert UolSource.recognises(f"{skeletons}#2-1")
    assert not UolSource.recognises("user1.txt")
    source = UolSource.open(str(skeletons), SourceOptions())
    assert any("Up is taken to be y" in note for note in source.notes)
    assert next(iter(source.frames())).head == pytest.approx((4.5, 0, 1.6), abs=1e-3)


def test_a_file_may_have_a_number_sign_in_its_name(tmp_path: Path) -> None:
    path = tmp_path / "skeletons.txt#2"
    path.write_text("")
    assert split_spec(str(path)) == (path, None, None)
    assert split_spec("a#b/skeletons.txt#2") == (Path("a#b/skeletons.txt"), 2, None)


def test_all_pairs_who_meet_are_read(tmp_path: Path) -> None:
    one, two = meeting()
    assert one is not None
    assert two is not None
    third = two.copy()
    third[:, :, 0] += 1
    one[23:], third[:23] = math.nan, math.nan  # 1 leaves as 3 comes
    tracks = read_uol_pairs(write(tmp_path / "skeletons.txt", [one, two, third]))
    assert sorted(t.name[-5:] for t in tracks) == ["p1_p2", "p2_p1", "p2_p3", "p3_p2"]


def test_a_changed_tracking_id_is_noted(skeletons: Path) -> None:
    lines = skeletons.read_text().splitlines()
    lines[-1] = lines[-1].replace(",72057590 ", ",99 ")
    skeletons.write_text("\n".join(lines))
    assert "The tracking id of person 1 changes" in read_uol(skeletons).notes[0]


@pytest.mark.parametrize("base", ["torso", "head"])
def test_the_robot_may_stand_under_the_head(tmp_path: Path, base: Any) -> None:
    one, two = meeting()
    assert two is not None
    two[:, FILE_JOINTS.index("Head"), 0] += 0.1  # leans 10 cm toward the other
    found = read_uol(write(tmp_path / "skeletons.txt", [one, two]), UolOptions(base=base))
    lean = 0.0 if base == "torso" else 0.1
    assert distance(found.track.head) == pytest.approx(4.5 - lean - found.track.t, abs=1e-3)
    assert found.robot_face[0] == pytest.approx(0.1 - lean, abs=1e-3)


@pytest.mark.parametrize(
    ("row", "change", "message"),
    [
        (3, lambda s: s[: len(s) // 3], r"skeletons\.txt, row 3: torn row: \d+ numbers"),
        (4, lambda s: s.replace(" 3.000000", " three", 1), "row 4: 'three', number 3 of the row"),
        (5, lambda s: s.replace(" 3.000000", " inf", 1), "row 5: number 3 of the row is infinite"),
        (6, lambda s: s.replace(" 3.000000", " 3000", 1), "row 6: a coordinate of 3000 .*metres"),
        (7, lambda s: "noon" + s, "row 7: 'noon5.*is not a number"),
        (8, lambda s: "5e8" + s[s.index(",") :], "row 8: the time does not grow"),
        (9, lambda s: "nan" + s[s.index(",") :], "row 9: the time is missing"),
        (46, lambda s: "500000999" + s[s.index(",") :], r"row 46: nothing for 99\d s before"),
        (1, lambda s: s.replace(",", ";"), "row 1: '5.*is not a number"),
    ],
)
def test_a_bad_row_is_named(skeletons: Path, row: int, change: Any, message: str) -> None:
    lines = skeletons.read_text().splitlines()
    lines[row - 1] = change(lines[row - 1])
    skeletons.write_text("\n".join(lines))
    with pytest.raises(DataError, match=message):
        read_uol(skeletons)


def test_stamps_in_milliseconds_are_suspected_and_can_be_told(tmp_path: Path) -> None:
    t = np.arange(46) / RATE * 1000
    path = write(tmp_path / "skeletons.txt", meeting(), t)
    with pytest.raises(DataError, match="are these milliseconds"):
        read_uol(path)
    found = read_uol(path, UolOptions(time_unit=0.001))
    assert found.track.duration == pytest.approx(3.0, abs=1e-3)


@pytest.mark.parametrize(
    ("slots", "message"),
    [
        ([0], "a greeting needs two people; there is only 1"),
        ([], "a greeting needs two people; there are only none"),
    ],
)
def test_one_person_greets_nobody(tmp_path: Path, slots: list[int], message: str) -> None:
    people = meeting()
    path = write(tmp_path / "skeletons.txt", people)
    if slots:
        write(path, [people[i] for i in slots])
    else:
        path.write_text("1.0,,\n1.1,,\n")
    with pytest.raises(DataError, match=message):
        UolSource.open(str(path), SourceOptions())
    with pytest.raises(DataError, match=message):
        read_uol_pairs(path)


def test_pairs_that_are_not_there_are_refused(skeletons: Path, tmp_path: Path) -> None:
    for suffix, message in (
        ("#3", "there is no person 3; valid: 1, 2"),
        ("#1-7", "there is no person 7; valid: 1, 2"),
        ("#2-2", r"person 2 cannot greet themselves; write skeletons\.txt#PERSON-PARTNER"),
    ):
        with pytest.raises(DataError, match=message):
            UolSource.open(f"{skeletons}{suffix}", SourceOptions())
    one, two = meeting()
    assert one is not None
    assert two is not None
    one[23:], two[:23] = math.nan, math.nan
    apart = write(tmp_path / "skeletons.txt", [one, two])
    with pytest.raises(DataError, match="no two people are ever seen at the same time"):
        read_uol_pairs(apart)
    with pytest.raises(DataError, match="never seen at the same time"):
        read_uol(apart)
    with pytest.raises(DataError, match="there is no such file"):
        read_uol(tmp_path / "none" / "skeletons.txt")


def test_without_feet_the_vertical_must_be_told(tmp_path: Path) -> None:
    slots = [s for s in meeting() if s is not None]
    for slot in slots:
        slot[:, [FILE_JOINTS.index(f) for f in ("FootLeft", "FootRight")]] = 0
    path = write(tmp_path / "skeletons.txt", list(slots))
    with pytest.raises(DataError, match="which axis is up"):
        read_uol(path)
    with pytest.raises(DataError, match="the floor is unknown"):
        read_uol(path, UolOptions(vertical="y"))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vertical": "up"}, "no axis 'up'; valid: x, -x, y"),
        ({"face_axis": "y"}, "face axis cannot be y, which runs along the bone"),
        ({"base": "feet"}, "no base 'feet'; valid: torso, head"),
        ({"time_unit": 0.0}, "time unit must be positive"),
    ],
)
def test_impossible_options_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises((ParameterError, UnknownNameError), match=message):
        UolOptions(**change)


def test_joints_at_the_camera_are_unknown(skeletons: Path) -> None:
    text = skeletons.read_text().splitlines()
    cells = text[0].split(",")
    words = cells[1].split()
    words[1 + 4 * 7 : 1 + 4 * 7 + 3] = ["0", "0", "0"]
    text[0] = ",".join([cells[0], " ".join(words), *cells[2:]])
    skeletons.write_text("\n".join(text))
    head = read_kinect_skeletons(skeletons).people[1][:, FILE_JOINTS.index("Head")]
    assert np.isnan(head[0, :3]).all()
    assert np.isfinite(head[1:, :3]).all()


@given(st.floats(-math.pi, math.pi), st.floats(-5, 5), st.floats(-5, 5))
def test_a_greeting_does_not_depend_on_where_the_world_begins(
    turn: float, x: float, y: float
) -> None:
    t = np.arange(9) / RATE

    def body(moved: Pose2D, seed: int) -> Body:
        rng = np.random.default_rng(seed)
        head = np.array([moved.to_world(tuple(p)) for p in rng.uniform(-2, 2, (9, 3)).tolist()])
        heading = rng.uniform(-3, 3, 9) + moved.yaw
        rotation = Rotation.from_euler("z", moved.yaw) * Rotation.from_quat(rng.normal(size=(9, 4)))
        joints = {"l_wrist": head + np.array([0, 0, 1])}
        return Body(head, head[:, :2], heading, joints, rotation.as_quat())

    here, there = (
        greeting(t, body(pose, 1), body(pose, 2)).track for pose in (ORIGIN, Pose2D(x, y, turn))
    )
    assert distance(here.head) == pytest.approx(distance(there.head))
    assert there.joints["l_wrist"] == pytest.approx(here.joints["l_wrist"])
    assert observe(there).values == pytest.approx(observe(here).values, abs=1e-6, nan_ok=True)


# The thesis's own way (3.5.1), against numbers worked out by hand.


def line(distances: list[float], rate: float, **change: Any) -> Track:
    """A person straight ahead of a robot that stands still."""
    head = np.array([[d, 0.0, 1.2] for d in distances])
    return Track.build(np.arange(len(head)) / rate, head, **change)


def test_means_of_groups_of_a_fifth_of_a_second() -> None:
    seen = thesis_observations(line([4.0, 3.9, 3.7, 3.6, 3.3, 3.3, 3.0], 10), "mean")
    assert seen.t == pytest.approx([0.2, 0.4, 0.6])
    assert seen.values[:, 0] == pytest.approx([3.8, 3.45, 3.15])
    assert seen.values[:, 1] == pytest.approx([1.5, 2.0, 1.5])


def test_the_partners_own_steps_are_not_the_persons_speed() -> None:
    """(3.15) takes both distances to where the partner is now."""
    robot = np.array([[0.1 * k, 0, 0] for k in range(11)])
    head = np.array([[3.0 - 0.1 * k, 0, 1.2] for k in range(11)])  # stands at x = 3
    track = Track.build(np.arange(11) / 10, head, robot=robot)
    seen = thesis_observations(track, "mean")
    assert seen.values[:, 1] == pytest.approx(0, abs=1e-9)
    assert seen.values[:, 0] == pytest.approx([2.85, 2.65, 2.45, 2.25, 2.05])


def test_gestures_phases_and_smiles_are_carried_along() -> None:
    track = line(
        [3.0] * 11, 10, smile=np.arange(11) / 5.0,
        gestures=np.array([[k >= 4, 0, math.nan] for k in range(11)], dtype=float),
        phases=np.array([1] * 5 + [4] * 6),
    )  # fmt: skip
    seen = thesis_observations(track, "mean")
    assert seen.values[:, 3] == pytest.approx([0.3, 0.7, 1.1, 1.5, 1.9])
    assert seen.values[:, 4].tolist() == [0, 1, 1, 1, 1]
    assert np.isnan(seen.values[:, [2, 6]]).all()
    assert seen.phases is not None
    assert seen.phases.tolist() == [1, 1, 4, 4, 4]


def test_a_group_without_frames_is_unknown() -> None:
    track = line([3.0, 3.0, 3.0, 3.0, 3.0, 3.0], 10)
    gap = Track.build(np.array([0, 0.1, 0.2, 0.7, 0.8, 1.0]), track.head)
    seen = thesis_observations(gap, "mean")
    assert np.isnan(seen.values[1:3]).all()
    assert np.isfinite(seen.values[[0, 3, 4], 0]).all()


def test_what_cannot_be_grouped_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"lasts 0\.10 s; the first observation needs 0\.2 s"):
        thesis_observations(line([1.0, 1.0], 10))
    with pytest.raises(UnknownNameError, match="no aggregate 'mode'; valid: mean, median"):
        thesis_observations(line([1.0] * 9, 10), "mode")  # type: ignore[arg-type]


def test_means_of_a_recording_agree_with_the_usual_path(skeletons: Path) -> None:
    found = read_uol(skeletons, UolOptions(base="head"))
    thesis = thesis_observations(found.track, "mean", robot_face=found.robot_face)
    usual = observe(found.track, found.robot_face)
    n = min(len(thesis), len(usual))
    assert thesis.values[:n, 0] == pytest.approx(usual.values[:n, 0], abs=0.04)
    assert thesis.values[1:n, 1] == pytest.approx(usual.values[1:n, 1], abs=0.02)
    assert thesis.values[:n, 2] == pytest.approx(0, abs=1e-3)
