"""ISR-UoL: two people a recording, both greetings, and what can be wrong with the files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from shared_data import shared_file

from kendon.errors import DataError, ParameterError
from kendon.features import distance, observe
from kendon.features.proxemics import to_world
from kendon.person import FloatArray, Track
from kendon.sources.base import SourceOptions
from kendon.sources.isr_uol import (
    FILE_JOINTS,
    IsrUolSource,
    read_isr_uol,
    read_isr_uol_pairs,
)


def joints(
    places: FloatArray, heading: float, *, floor: float = -0.9, frames: int | None = None
) -> FloatArray:
    """An upright person at places (T, 2) with a heading [rad], as the dataset writes them.

    Labels are mirrored: the person's right is called left. Shape (T, 15, 6).
    """
    ahead = np.array([math.cos(heading), math.sin(heading)])
    left = np.array([-ahead[1], ahead[0]])
    body = {
        "head": (0, 0, 1.6), "neck": (0, 0, 1.4), "torso": (0, 0, 1.1),
        "right_shoulder": (0, 0.2, 1.4), "right_elbow": (0, 0.25, 1.1),
        "left_shoulder": (0, -0.2, 1.4), "left_elbow": (0, -0.25, 1.1),
        "right_hand": (0.2, 0.25, 1.0), "left_hand": (0.5, -0.1, 1.0),
        "right_hip": (0, 0.1, 0.9), "right_knee": (0, 0.1, 0.5), "right_foot": (0, 0.1, 0.0),
        "left_hip": (0, -0.1, 0.9), "left_knee": (0, -0.1, 0.5), "left_foot": (0, -0.1, 0.0),
    }  # fmt: skip
    result = np.zeros((len(places), 15, 6))
    for i, name in enumerate(FILE_JOINTS):
        forward, aside, up = body[name]
        result[:, i, :2] = places + forward * ahead + aside * left
        result[:, i, 2] = up + floor
        result[:, i, 3] = heading - math.pi + math.pi / 2
    return result[:frames]


def write(folder: Path, name: str, values: FloatArray) -> Path:
    path = folder / name
    np.savetxt(path, values.reshape(len(values), -1), fmt="%.9f")
    return path


def pair(folder: Path, frames: int = 91, speed: float = 1.0) -> Path:
    """User 1 walks from y = 4 m toward user 2, who stands at y = 0, three metres from the camera.

    User 1 comes along -y, user 2 looks along +y.
    """
    t = np.arange(frames) / 30
    walk = np.column_stack([np.full(frames, 3.0), 4 - speed * t])
    stand = np.column_stack([np.full(frames, 3.0), 1e-4 * np.sin(t)])
    write(folder, "a01_s01_user2.txt", joints(stand, math.pi / 2))
    return write(folder, "a01_s01_user1.txt", joints(walk, -math.pi / 2))


def test_a_walk_toward_the_partner_has_its_distance_and_speed(tmp_path: Path) -> None:
    track = read_isr_uol(pair(tmp_path))
    seen = observe(track)
    assert distance(track.head) == pytest.approx(4 - track.t, abs=1e-3)
    assert seen.values[1:, 1] == pytest.approx(1.0, abs=0.01)
    assert np.isnan(seen.values[:, 2]).all()  # the dataset knows no gaze
    assert track.name == "a01_s01_user1"


def test_the_one_who_stands_does_not_approach(tmp_path: Path) -> None:
    _, stands = read_isr_uol_pairs(pair(tmp_path))
    seen = observe(stands)
    assert distance(stands.head) == pytest.approx(4 - stands.t, abs=1e-3)
    assert seen.values[1:, 1] == pytest.approx(0.0, abs=0.01)


def test_positions_are_in_the_partners_base_frame(tmp_path: Path) -> None:
    walker, stander = read_isr_uol_pairs(pair(tmp_path))
    for track in (walker, stander):  # each stands straight ahead of the other
        assert track.head[0] == pytest.approx([4, 0, 1.6], abs=1e-3)
        # The walker's right shoulder is on the left of whoever it faces.
        assert track.joints["r_shoulder"][0] == pytest.approx([4, 0.2, 1.4], abs=1e-3)
        assert track.joints["l_wrist"][0] == pytest.approx([3.8, -0.25, 1.0], abs=1e-3)
    assert walker.robot[:, 2] == pytest.approx(math.pi / 2)
    assert stander.robot[0] == pytest.approx([3, 4, -math.pi / 2], abs=1e-3)


def test_the_world_place_of_a_person_is_where_the_other_track_has_its_robot(
    tmp_path: Path,
) -> None:
    one, two = read_isr_uol_pairs(pair(tmp_path))
    assert to_world(one.head, one.robot) == pytest.approx(two.robot[:, :2], abs=1e-6)


def test_the_frame_rate_may_be_told(tmp_path: Path) -> None:
    path = pair(tmp_path)
    assert read_isr_uol(path).t[30] == pytest.approx(1.0)
    assert IsrUolSource.open(str(path), SourceOptions(fps=15)).track.t[30] == pytest.approx(2.0)
    with pytest.raises(ParameterError, match="must be positive, not 0"):
        read_isr_uol(path, fps=0)


def test_without_an_orientation_the_shoulders_tell_the_heading(tmp_path: Path) -> None:
    path = pair(tmp_path)
    values = np.loadtxt(tmp_path / "a01_s01_user2.txt").reshape(-1, 15, 6)
    values[:, FILE_JOINTS.index("torso"), 3] = np.nan
    write(tmp_path, "a01_s01_user2.txt", values)
    assert read_isr_uol(path).robot[:, 2] == pytest.approx(math.pi / 2)


def test_the_longer_file_is_cut_and_a_note_says_so(tmp_path: Path) -> None:
    path = pair(tmp_path)
    other = tmp_path / "a01_s01_user2.txt"
    other.write_text("".join(other.read_text().splitlines(keepends=True)[:80]))
    source = IsrUolSource.open(str(path), SourceOptions())
    assert len(source.track) == 80
    assert "91 frames and a01_s01_user2.txt 80" in source.notes[0]


def test_a_frozen_tracker_is_noted_a_person_who_stands_still_is_not(tmp_path: Path) -> None:
    path = pair(tmp_path, frames=150)
    assert IsrUolSource.open(str(path), SourceOptions()).notes == ()
    values = np.loadtxt(path).reshape(-1, 15, 6)
    values[30:100] = values[30]
    write(tmp_path, path.name, values)
    (note,) = IsrUolSource.open(str(path), SourceOptions()).notes
    assert "a01_s01_user1.txt does not move to the last digit from 1.0 to 3.3 s" in note


def test_a_joint_at_the_camera_is_unknown(tmp_path: Path) -> None:
    path = pair(tmp_path)
    values = np.loadtxt(path).reshape(-1, 15, 6)
    values[10, FILE_JOINTS.index("head")] = 0
    write(tmp_path, path.name, values)
    track = read_isr_uol(path)
    assert np.isnan(track.head[10]).all()
    assert np.isfinite(track.head[[9, 11]]).all()


@pytest.mark.parametrize("name", ["a05_s10", "a06_s05", "a03_s09_t2", "a03_s07_t03"])
def test_damaged_recordings_are_named_in_a_note(tmp_path: Path, name: str) -> None:
    pair(tmp_path)
    for user in "12":
        (tmp_path / f"a01_s01_user{user}.txt").rename(tmp_path / f"{name}_user{user}.txt")
    source = IsrUolSource.open(str(tmp_path / f"{name}_user1.txt"), SourceOptions())
    assert "known to be damaged" in source.notes[0]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ("2:0:north", r"a01_s01_user1\.txt, row 2: 'north', number 1 of the row, is not a number"),
        ("3:89:", r"row 3: torn row: 89 numbers where there should be 90"),
        ("4:5:1 2", r"row 4: torn row: 91 numbers"),
        ("5:1:inf", r"row 5: number 2 of the row is infinite"),
        ("6:0:2345.6", r"row 6: a coordinate of 2345\.6 is not within 100 m.*millimetres"),
        ("7:0:1e999", r"row 7: number 1 of the row is infinite"),
    ],
)
def test_a_bad_cell_is_named_with_file_and_row(tmp_path: Path, damage: str, message: str) -> None:
    path = pair(tmp_path)
    row, place, value = damage.split(":")
    rows = [line.split() for line in path.read_text().splitlines()]
    rows[int(row) - 1][int(place)] = value
    path.write_text("\n".join(" ".join(r) for r in rows))
    with pytest.raises(DataError, match=message):
        read_isr_uol(path)


def test_a_file_of_text_or_of_nothing_is_refused(tmp_path: Path) -> None:
    path = pair(tmp_path)
    path.write_text("")
    with pytest.raises(DataError, match=r"user1\.txt: the file is empty"):
        read_isr_uol(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DataError, match="no text file"):
        read_isr_uol(path)
    (tmp_path / "a02_s01_user1.txt").mkdir()
    with pytest.raises(DataError, match="this is a folder"):
        read_isr_uol(tmp_path / "a02_s01_user1.txt")
    with pytest.raises(DataError, match=r"a09_s01_user1\.txt: there is no such file"):
        read_isr_uol(tmp_path / "a09_s01_user1.txt")


def test_a_missing_partner_is_named(tmp_path: Path) -> None:
    path = pair(tmp_path)
    (tmp_path / "a01_s01_user2.txt").unlink()
    with pytest.raises(DataError, match=r"the partner's file a01_s01_user2\.txt is not beside it"):
        read_isr_uol(path)


def test_a_name_that_tells_no_user_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="called like a01_s01_user1"):
        read_isr_uol(tmp_path / "skeleton.txt")


def test_the_error_of_a_damaged_recording_says_that_it_is_known(tmp_path: Path) -> None:
    for user in "12":
        (tmp_path / f"a05_s10_user{user}.txt").write_text("1 2 3")
    with pytest.raises(DataError, match=r"row 1: torn row.*known to be damaged"):
        read_isr_uol(tmp_path / "a05_s10_user1.txt")


def test_people_who_are_never_seen_together_are_no_pair(tmp_path: Path) -> None:
    path = pair(tmp_path)
    values = np.loadtxt(path).reshape(-1, 15, 6)
    values[:, FILE_JOINTS.index("head")] = 0
    write(tmp_path, path.name, values)
    with pytest.raises(DataError, match="never seen at the same time"):
        read_isr_uol(path)


def test_names_of_the_dataset_are_recognised() -> None:
    for name in ("a01_s01_user1.txt", "deep/a03_s09_t12_user2.txt"):
        assert IsrUolSource.recognises(name)
    for name in ("a01_s01_user3.txt", "a01_s01.txt", "skeletons.txt", "a01_s01_user1.csv"):
        assert not IsrUolSource.recognises(name)


def recording(name: str) -> tuple[Track, Track]:
    one, two = read_isr_uol_pairs(shared_file(f"data/isr_uol/{name}_user1.txt"))
    return one, two


def test_a_real_handshake_is_near_and_both_see_the_same_distance() -> None:
    one, two = recording("a01_s01")
    assert one.duration == pytest.approx(59.7, abs=0.1)
    ways = [distance(track.head) for track in (one, two)]
    for way in ways:
        assert 0.5 < way.min() < 1.2
        assert 0.6 < np.median(way) < 1.2
    # They differ only by how far heads lean out over torsos.
    assert np.median(np.abs(ways[0] - ways[1])) < 0.05
    assert np.abs(ways[0] - ways[1]).max() < 0.15


def test_in_a_real_handshake_the_right_hands_meet() -> None:
    one, two = recording("a01_s01")

    def world(track: Track, name: str) -> FloatArray:
        points = track.joints[name]
        return np.column_stack([to_world(points, track.robot), points[:, 2]])

    gaps = {
        (a, b): np.linalg.norm(world(one, a) - world(two, b), axis=1).min()
        for a in ("l_wrist", "r_wrist")
        for b in ("l_wrist", "r_wrist")
    }
    assert gaps["r_wrist", "r_wrist"] < 0.05
    assert min(gap for hands, gap in gaps.items() if hands != ("r_wrist", "r_wrist")) > 0.3


@pytest.mark.parametrize(
    ("name", "nearest", "farthest"),
    [("a01_s01", 0.5, 1.2), ("a02_s08", 0.2, 1.5), ("a07_s03", 0.7, 1.2), ("a08_s02", 1.2, 2.4)],
)
def test_real_recordings_have_people_upright_before_each_other(
    name: str, nearest: float, farthest: float
) -> None:
    for track in recording(name):
        way = distance(track.head)
        assert nearest < way.min()
        assert way.max() < farthest
        assert 1.3 < np.median(track.head[:, 2]) < 1.9
        assert (track.head[:, 2] > track.joints["l_hip"][:, 2]).all()
        speeds = observe(track).values[:, 1]
        assert np.nanmax(np.abs(speeds)) < 2.0


def test_a_real_hug_comes_and_goes() -> None:
    one, _ = recording("a02_s08")
    way = observe(one).values[:, 0]
    assert (np.diff(np.sign(way - 0.8)) != 0).sum() > 20
