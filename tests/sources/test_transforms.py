"""The tree of frames: laws of poses, an independent interpolation, and what is not known."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from kendon.errors import DataError
from kendon.sources.transforms import MAX_HOLE, MAX_LATE, Poses, TransformTree

FloatArray = NDArray[np.float64]
Vec = tuple[float, float, float]
Quat = tuple[float, float, float, float]
Pose = tuple[Vec, Quat]

SECOND = 1_000_000_000
NOWHERE: Vec = (0.0, 0.0, 0.0)
UPRIGHT: Quat = (0.0, 0.0, 0.0, 1.0)
#: A clock far from zero, as real ones are, where floats of seconds lose nanoseconds.
START = 1_700_000_000 * SECOND + 123_456_789

metres = st.floats(-20, 20)
angles = st.floats(-math.pi, math.pi)


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    place = (draw(metres), draw(metres), draw(metres))
    turn = Rotation.from_euler("zyx", [draw(angles), draw(angles), draw(angles)])
    x, y, z, w = turn.as_quat().tolist()
    sign = draw(st.sampled_from([1.0, -1.0]))  # both stand for the same rotation
    return place, (sign * x, sign * y, sign * z, sign * w)


def matrices(found: Poses) -> FloatArray:
    """(N, 4, 4) homogeneous."""
    result = np.tile(np.eye(4), (len(found.position), 1, 1))
    result[:, :3, :3] = Rotation.from_quat(found.rotation).as_matrix()
    result[:, :3, 3] = found.position
    return result


def matrix(pose: Pose) -> FloatArray:
    return np.asarray(matrices(Poses(np.array([pose[0]]), np.array([pose[1]])))[0])


def at(*seconds: float) -> NDArray[np.int64]:
    return START + np.round(np.array(seconds) * SECOND).astype(np.int64)


def chain(samples: list[list[Pose]], *, spacing: float = 0.1) -> TransformTree:
    """Frames 0 - 1 - 2 - …, each moving in the one before through its poses."""
    tree = TransformTree()
    for number, told in enumerate(samples):
        for i, (place, turn) in enumerate(told):
            tree.add(f"{number}", f"{number + 1}", int(at(i * spacing)[0]), place, turn)
    return tree


chains = st.lists(st.lists(poses(), min_size=3, max_size=3), min_size=3, max_size=3)
moments = st.lists(st.floats(0, 0.2), min_size=1, max_size=4)


@given(chains)
def test_at_its_stamps_a_chain_is_the_product_of_its_poses(samples: list[list[Pose]]) -> None:
    found = matrices(chain(samples).lookup("0", "3", at(0, 0.1, 0.2)))
    for i in range(3):
        wanted = matrix(samples[0][i]) @ matrix(samples[1][i]) @ matrix(samples[2][i])
        np.testing.assert_allclose(found[i], wanted, atol=1e-9)


@given(chains, moments)
def test_there_and_back_is_nowhere(samples: list[list[Pose]], when: list[float]) -> None:
    tree = chain(samples)
    there = matrices(tree.lookup("0", "3", at(*when)))
    back = matrices(tree.lookup("3", "0", at(*when)))
    np.testing.assert_allclose(there @ back, np.tile(np.eye(4), (len(when), 1, 1)), atol=1e-9)


@given(chains, moments)
def test_two_ways_make_one(samples: list[list[Pose]], when: list[float]) -> None:
    tree = chain(samples)
    first = matrices(tree.lookup("0", "2", at(*when)))
    second = matrices(tree.lookup("2", "3", at(*when)))
    np.testing.assert_allclose(
        first @ second, matrices(tree.lookup("0", "3", at(*when))), atol=1e-9
    )


@given(st.lists(poses(), min_size=2, max_size=5), st.floats(0, 1))
def test_between_stamps_it_is_what_scipy_interpolates(samples: list[Pose], share: float) -> None:
    tree = chain([samples])
    stamps = [0.1 * i for i in range(len(samples))]
    when = share * stamps[-1]
    found = tree.lookup("0", "1", at(when))
    for axis in range(3):
        wanted = np.interp(when, stamps, [place[axis] for place, _ in samples])
        assert found.position[0, axis] == pytest.approx(wanted, abs=1e-6)
    half_turns = [
        (Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude()
        for (_, a), (_, b) in pairwise(samples)
    ]
    if max(half_turns) < 3.1:  # half a turn has no shorter way
        slerp = Slerp(stamps, Rotation.from_quat([turn for _, turn in samples]))
        off = slerp([when]).inv() * Rotation.from_quat(found.rotation)
        assert np.max(off.magnitude()) < 1e-6


@given(
    st.floats(-5, 5), st.floats(-2, 2), st.floats(0.01, 0.9), st.floats(-15, 15), st.floats(0, 1)
)
def test_a_steady_turn_and_walk_are_met_exactly(
    start: float, speed: float, spacing: float, rate: float, share: float
) -> None:
    # However far apart the stamps are, as long as less than half a turn lies between.
    rate = math.copysign(min(abs(rate), 3.0 / spacing), rate)
    told: list[Pose] = [
        (
            (start + speed * t, 0.0, 1.0),
            (0.0, 0.0, math.sin(rate * t / 2), math.cos(rate * t / 2)),
        )
        for t in (0.0, spacing, 2 * spacing)
    ]
    when = share * 2 * spacing
    found = chain([told], spacing=spacing).lookup("0", "1", at(when))
    assert found.position[0] == pytest.approx([start + speed * when, 0, 1], abs=1e-7)
    ahead = Rotation.from_quat(found.rotation[0]).apply([1, 0, 0])
    assert ahead == pytest.approx([math.cos(rate * when), math.sin(rate * when), 0], abs=1e-6)


@given(poses(), poses())
@settings(max_examples=30)
def test_frames_side_by_side_see_each_other_through_their_parent(one: Pose, two: Pose) -> None:
    tree = TransformTree()
    tree.add("base", "camera", 0, *one, static=True)
    tree.add("base", "face", START, *two)
    found = matrices(tree.lookup("camera", "face", at(0)))
    np.testing.assert_allclose(found[0], np.linalg.inv(matrix(one)) @ matrix(two), atol=1e-9)


def test_a_frame_is_where_it_is_in_itself() -> None:
    found = TransformTree().lookup("camera", "camera", at(0, 1))
    np.testing.assert_array_equal(found.position, np.zeros((2, 3)))
    np.testing.assert_array_equal(found.rotation, np.tile(UPRIGHT, (2, 1)))


def test_nothing_is_known_before_the_first_stamp_or_after_the_last() -> None:
    tree = chain([[((1, 0, 0), UPRIGHT), ((2, 0, 0), UPRIGHT)]])
    found = tree.lookup("0", "1", at(-1e-6, 0, 0.05, 0.1, 0.100001)).position[:, 0]
    np.testing.assert_allclose(found, [math.nan, 1, 1.5, 2, math.nan])


def test_a_long_hole_is_not_bridged() -> None:
    tree = TransformTree()
    for t, x in ((0.0, 0.0), (MAX_HOLE, 1.0), (2 * MAX_HOLE + 0.01, 2.0)):
        tree.add("base", "face", int(at(t)[0]), (x, 0.0, 0.0), UPRIGHT)
    found = tree.lookup("base", "face", at(MAX_HOLE / 2, MAX_HOLE * 1.5, 2 * MAX_HOLE + 0.01))
    np.testing.assert_allclose(found.position[:, 0], [0.5, math.nan, 2])


@given(st.permutations(range(8)))
def test_late_transforms_are_sorted(order: list[int]) -> None:
    tree = TransformTree()
    for i in order:
        tree.add("base", "face", int(at(i / 10)[0]), (i / 10, 0.0, 0.0), UPRIGHT)
    found = tree.lookup("base", "face", at(0.05, 0.33, 0.7))
    assert found.position[:, 0] == pytest.approx([0.05, 0.33, 0.7])
    assert tree.late == sum(i < max(order[: n + 1]) for n, i in enumerate(order))


def test_a_clock_that_goes_back_is_two_recordings() -> None:
    tree = TransformTree()
    tree.add("base", "face", int(at(5)[0]), NOWHERE, UPRIGHT)
    tree.add("base", "face", int(at(5 - MAX_LATE)[0]), NOWHERE, UPRIGHT)
    with pytest.raises(DataError, match=r"'face' go back by 1\.1 s .* two recordings in one"):
        tree.add("base", "face", int(at(5 - MAX_LATE - 0.1)[0]), NOWHERE, UPRIGHT)


def test_of_one_stamp_the_first_pose_holds_and_of_static_ones_the_last() -> None:
    tree = TransformTree()
    for x in (1.0, 2.0):
        tree.add("base", "face", START, (x, 0.0, 0.0), UPRIGHT)
        tree.add("base", "camera", 0, (x, 0.0, 0.0), UPRIGHT, static=True)
    assert tree.lookup("base", "face", at(0)).position[0, 0] == 1
    assert tree.lookup("base", "camera", at(0)).position[0, 0] == 2
    assert len(tree.stamps("face")) == 1


@pytest.mark.parametrize("moving_first", [True, False])
def test_stamped_poses_go_before_a_static_one(moving_first: bool) -> None:
    tree = TransformTree()
    for static in (not moving_first, moving_first):
        x = 1.0 if static else 2.0
        tree.add("base", "camera", START, (x, 0.0, 0.0), UPRIGHT, static=static)
    assert tree.lookup("base", "camera", at(0)).position[0, 0] == 2


def test_a_frame_may_change_its_parent() -> None:
    tree = TransformTree()
    tree.add("room", "table", 0, (10.0, 0.0, 0.0), UPRIGHT, static=True)
    tree.add("room", "cup", int(at(0)[0]), (1.0, 0.0, 0.0), UPRIGHT)
    tree.add("table", "cup", int(at(0.2)[0]), (1.0, 0.0, 0.0), UPRIGHT)
    found = tree.lookup("room", "cup", at(0, 0.1, 0.2)).position[:, 0]
    np.testing.assert_allclose(found, [1, 1, 11])
    assert tree.parents("cup") == ["room", "table"]


@pytest.mark.parametrize(
    ("place", "turn"),
    [
        ((math.nan, 0.0, 0.0), UPRIGHT),
        ((0.0, math.inf, 0.0), UPRIGHT),
        (NOWHERE, (0.0, 0.0, 0.0, 0.0)),
        (NOWHERE, (0.0, 0.0, 1.0, 1.0)),
        (NOWHERE, (math.nan, 0.0, 0.0, 1.0)),
    ],
)
def test_what_is_no_pose_is_left_out(place: Vec, turn: Quat) -> None:
    tree = TransformTree()
    tree.add("base", "face", START, place, turn)
    assert (tree.refused, tree.frames) == (1, [])
    assert np.isnan(tree.lookup("base", "face", at(0)).position).all()


def test_frames_that_lie_in_each_other() -> None:
    tree = TransformTree()
    tree.add("hen", "egg", 0, NOWHERE, UPRIGHT, static=True)
    tree.add("egg", "hen", 0, NOWHERE, UPRIGHT, static=True)
    tree.add("base", "base", 0, NOWHERE, UPRIGHT, static=True)
    with pytest.raises(DataError, match="lie in each other"):
        tree.lookup("base", "egg", at(0))
    assert len(tree.stamps("egg")) == 0


def test_a_static_frame_moves_with_its_parent() -> None:
    tree = chain([[((1, 0, 0), UPRIGHT), ((2, 0, 0), UPRIGHT)]])
    tree.add("1", "nose", 0, (0.1, 0.0, 0.0), UPRIGHT, static=True)
    np.testing.assert_array_equal(tree.stamps("nose"), at(0, 0.1))
    assert tree.connected("0", "nose")
    assert not tree.connected("0", "elsewhere")
