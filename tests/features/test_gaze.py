"""Gaze against closed forms, rays worked out by hand, and the thesis's own formulas."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from people import FloatArray, matrix, quaternion

from kendon.features.gaze import GAZE_CEILING, blend, gaze_of_eyes, gaze_of_head, pierce
from kendon.features.gaze_of_track import blended, eye_gaze, head_gaze
from kendon.features.smile import smile
from kendon.geometry import Quaternion, Vec3

FACE: Vec3 = (0.0, 0.0, 1.2)
TAN30 = math.tan(math.radians(30))
TILTS = [0, 5, -5, 30, -30, 60, 89]


def of_head(head: Vec3, rotation: Quaternion, face: Vec3 = FACE) -> float:
    return float(head_gaze(np.array(head), np.array(rotation), np.array(face)))


def of_eyes(eyes: tuple[Vec3, Vec3], directions: tuple[Vec3, Vec3], face: Vec3 = FACE) -> float:
    return float(eye_gaze(np.array(eyes), np.array(directions), np.array(face)))


def by_hand(origin: Vec3, direction: Vec3, face: Vec3) -> float:
    """(3.7) and (3.8) by similar triangles, a coordinate at a time."""
    ahead = origin[0] - face[0]
    y = origin[1] + ahead * direction[1] / -direction[0]
    z = origin[2] + ahead * direction[2] / -direction[0]
    d = math.sqrt(ahead**2 + (y - origin[1]) ** 2 + (z - origin[2]) ** 2)
    return math.sqrt((y - face[1]) ** 2 + (z - face[2]) ** 2) / (TAN30 * d)


# ---- the head (Gaze Detector 2)


@pytest.mark.parametrize("way", [0.4, 2.0, 7.5])
@pytest.mark.parametrize("degrees", TILTS)
def test_straight_ahead_gaze_is_the_sine_of_the_angle(degrees: float, way: float) -> None:
    off = math.radians(degrees)
    expected = abs(math.sin(off)) / TAN30
    head = (way, 0.0, FACE[2])
    assert of_head(head, quaternion(math.pi + off)) == pytest.approx(expected, abs=1e-9)
    assert of_head(head, quaternion(math.pi, off)) == pytest.approx(expected, abs=1e-9)


def test_30_degrees_beside_is_by_the_formula_less_than_the_rim() -> None:
    # The rim of a tilted cone: sin 30 / tan 30, since the way to the gaze point is longer.
    rotation = quaternion(math.pi + math.radians(30))
    assert of_head((3.0, 0.0, 1.2), rotation) == pytest.approx(math.cos(math.radians(30)))


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-3, 3))
def test_only_the_angle_to_the_axis_counts_and_roll_does_not(
    yaw: float, pitch: float, roll: float
) -> None:
    # cos(angle) = cos(yaw) cos(pitch) for two turns one after the other.
    sine = math.sqrt(1 - (math.cos(yaw) * math.cos(pitch)) ** 2)
    rotation = quaternion(math.pi + yaw, pitch, roll)
    assert of_head((2.0, 0.0, 1.2), rotation) == pytest.approx(sine / TAN30, abs=1e-7)


@given(
    st.floats(0.3, 8), st.floats(-3, 3), st.floats(0.5, 2.2), st.floats(-1.2, 1.2),
    st.floats(-1.2, 1.2), st.floats(-0.5, 0.25), st.floats(-0.5, 0.5), st.floats(0.5, 1.8),
)  # fmt: skip
def test_off_the_axis_the_ray_is_followed_to_the_plane(
    x: float, y: float, z: float, yaw: float, pitch: float, fx: float, fy: float, fz: float
) -> None:
    face = (fx, fy, fz)
    out = matrix(math.pi + yaw, pitch)[:, 0]
    expected = min(by_hand((x, y, z), (out[0], out[1], out[2]), face), GAZE_CEILING)
    got = of_head((x, y, z), quaternion(math.pi + yaw, pitch), face)
    assert got == pytest.approx(expected, abs=1e-6)


@given(st.floats(0.5, 8), st.floats(-3, 3), st.floats(1, 2), st.floats(-1.3, 1.3), st.booleans())
def test_the_thesiss_formulas_3_9_and_3_10(
    tx: float, ty: float, tz: float, angle: float, sideways: bool
) -> None:
    # One turn at a time: (3.9) and (3.10) leave out what yaw adds to the way pitch acts on. The
    # thesis's gp_y counts to the right of the robot, hence -t_y; its face is at the origin here.
    rz, ry = (angle, 0.0) if sideways else (0.0, angle)
    gp_y = abs(tx) * math.tan(rz) - ty
    gp_z = abs(tx) * math.tan(ry) + tz
    beside = math.hypot(gp_y - 0.0, gp_z - FACE[2])
    d = math.sqrt(tx**2 + (gp_y + ty) ** 2 + (gp_z - tz) ** 2)
    expected = min(beside / (TAN30 * d), GAZE_CEILING)
    rotation = quaternion(math.pi + rz, -ry)  # REP-103: positive pitch looks down
    assert of_head((tx, ty, tz), rotation) == pytest.approx(expected, abs=1e-7)


@given(st.floats(0.3, 8), st.floats(-4, 4), st.floats(0.3, 2.3))
def test_who_looks_at_the_face_from_anywhere_has_gaze_0(x: float, y: float, z: float) -> None:
    yaw = math.atan2(FACE[1] - y, FACE[0] - x)
    pitch = math.atan2(z - FACE[2], math.hypot(x, y))
    assert of_head((x, y, z), quaternion(yaw, pitch)) == pytest.approx(0, abs=1e-7)


@pytest.mark.parametrize("yaw", [0, 45, -45, 89.999, -89.999, 0.001])
def test_a_ray_that_runs_away_gets_the_ceiling(yaw: float) -> None:
    # The first one's ray, followed backward, would meet the robot's face at once.
    for head in [(0.5, 0.0, 1.2), (2.0, 0.3, 1.6)]:
        assert of_head(head, quaternion(math.radians(yaw))) == GAZE_CEILING


@pytest.mark.parametrize("direction", [(0, 1, 0), (0, 0, -1), (1, 0, 0), (1e-310, 1, 0)])
def test_a_ray_along_the_plane_gets_the_ceiling(direction: Vec3) -> None:
    eyes = ((2.0, 0.0, 1.2), (2.0, 0.0, 1.2))
    assert of_eyes(eyes, (direction, direction)) == GAZE_CEILING


def test_a_face_in_the_plane_looks_nowhere() -> None:
    assert of_head((0.0, 1.0, 1.2), quaternion(-math.pi / 2)) == GAZE_CEILING
    assert of_head(FACE, quaternion(math.pi)) == GAZE_CEILING


@given(
    st.tuples(*[st.floats(-1000, 1000)] * 3), st.tuples(*[st.floats(-1, 1)] * 4),
    st.tuples(*[st.floats(-2, 2)] * 3),
)  # fmt: skip
def test_whatever_is_known_gives_a_gaze_between_0_and_the_ceiling(
    head: Vec3, rotation: Quaternion, face: Vec3
) -> None:
    got = of_head(head, rotation, face)
    if max(map(abs, rotation)) > 1e-100:  # its square is a number above 0
        assert 0 <= got <= GAZE_CEILING
    direction: Vec3 = rotation[:3]
    got = of_eyes((head, head), (direction, direction), face)
    assert np.isnan(got) if direction == (0, 0, 0) else 0 <= got <= GAZE_CEILING


@pytest.mark.parametrize("place", range(3))
def test_one_unknown_coordinate_makes_gaze_unknown(place: int) -> None:
    head = [2.0, 0.1, 1.5]
    head[place] = math.nan
    assert np.isnan(of_head((head[0], head[1], head[2]), quaternion(math.pi)))
    for k in range(4):
        rotation = list(quaternion(3.0, 0.1, 0.1))
        rotation[k] = math.nan
        x, y, z, w = rotation
        assert np.isnan(of_head((2.0, 0.1, 1.5), (x, y, z, w)))


def test_a_quaternion_of_zeros_is_an_unknown_rotation() -> None:
    assert np.isnan(of_head((2.0, 0.0, 1.2), (0.0, 0.0, 0.0, 0.0)))


@given(st.floats(0.1, 10), st.floats(-1.2, 1.2))
def test_the_length_of_the_quaternion_does_not_matter(length: float, yaw: float) -> None:
    unit = quaternion(math.pi + yaw, 0.2, 0.1)
    x, y, z, w = (length * v for v in unit)
    head = (2.0, 0.2, 1.6)
    assert of_head(head, (x, y, z, w)) == pytest.approx(of_head(head, unit))


def test_many_heads_at_once_are_each_head_alone() -> None:
    rng = np.random.default_rng(5)
    heads, rotations = rng.normal(size=(4, 6, 3)), rng.normal(size=(4, 6, 4))
    heads[1, 2], rotations[3, 3] = np.nan, np.nan
    got = head_gaze(heads, rotations, np.array(FACE))
    assert got.shape == (4, 6)
    alone = [[of_head(h, q) for h, q in zip(*pair, strict=True)]
             for pair in zip(heads, rotations, strict=True)]  # fmt: skip
    np.testing.assert_array_equal(got, alone)


# ---- arrays of people and one person

#: Coordinates that meet every rule: behind the plane, along it, unknown, no direction at all.
numbers = st.sampled_from([-2.0, 0.0, 1.0, 1e-300, 1e200, math.nan]) | st.floats(-5, 5)
faces = st.tuples(*[st.floats(-1, 1)] * 3)


@given(st.lists(st.tuples(*[numbers] * 7), min_size=1), faces)
def test_arrays_of_heads_give_what_each_head_gives(
    rows: list[tuple[float, ...]], face: Vec3
) -> None:
    table = np.array(rows)
    got = head_gaze(table[:, :3], table[:, 3:], face)
    alone = [gaze_of_head((a, b, c), (x, y, z, w), face) for a, b, c, x, y, z, w in rows]
    np.testing.assert_allclose(got, alone, rtol=1e-12, atol=1e-12)


@given(st.lists(st.tuples(*[numbers] * 12), min_size=1), faces)
def test_arrays_of_eyes_give_what_each_pair_gives(
    rows: list[tuple[float, ...]], face: Vec3
) -> None:
    table = np.array(rows).reshape(-1, 2, 2, 3)
    got = eye_gaze(table[:, 0], table[:, 1], face)
    pairs: Any = [[tuple(map(tuple, pair)) for pair in row] for row in table.tolist()]
    alone = [gaze_of_eyes(eyes, directions, face) for eyes, directions in pairs]
    np.testing.assert_allclose(got, alone, rtol=1e-9, atol=1e-9)


@given(st.lists(st.tuples(*[st.floats(0, 4) | st.just(math.nan)] * 3), min_size=1))
def test_arrays_of_gazes_are_blended_as_each_is(rows: list[tuple[float, float, float]]) -> None:
    np.testing.assert_array_equal(blended(*np.array(rows).T), [blend(*row) for row in rows])


# ---- the eyes (Gaze Detector 1)

EYES: tuple[Vec3, Vec3] = ((1.0, -0.03, 1.5), (1.0, 0.03, 1.5))


@given(st.tuples(*[st.floats(-1, 1)] * 4), st.floats(0.2, 5), st.floats(0.2, 5))
def test_the_gaze_point_is_the_mean_of_both_eyes_points(
    sides: tuple[float, float, float, float], length0: float, length1: float
) -> None:
    # Each eye looks at a known point of the plane; its direction may have any length.
    targets = np.array([[0.0, sides[0], 1 + sides[1]], [0.0, sides[2], 1 + sides[3]]])
    lengths = np.array([[length0], [length1]])
    got = eye_gaze(np.array(EYES), lengths * (targets - np.array(EYES)), np.array(FACE))
    gp = targets.mean(axis=0)
    d = math.dist(gp, (1.0, 0.0, 1.5))
    assert float(got) == pytest.approx(min(math.dist(gp, FACE) / (TAN30 * d), GAZE_CEILING))


def test_eyes_that_look_at_the_face_have_gaze_0_and_squint_past_it_too() -> None:
    straight = tuple(tuple(f - e for f, e in zip(FACE, eye, strict=True)) for eye in EYES)
    assert eye_gaze(np.array(EYES), np.array(straight), np.array(FACE)) == pytest.approx(0)
    # Parallel lines of sight: 3 cm to either side, their mean on the face.
    parallel = np.array([[-1.0, 0.0, -0.3]] * 2)
    assert eye_gaze(np.array(EYES), parallel, np.array(FACE)) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("blind", [0, 1])
@pytest.mark.parametrize("closed", [(math.nan,) * 3, (0.0, 0.0, 0.0)], ids=["nan", "zeros"])
def test_one_known_eye_decides_alone(blind: int, closed: Vec3) -> None:
    directions = np.array([[-1.0, 0.2, -0.1], [-1.0, 0.2, -0.1]])
    directions[blind] = closed
    eye = EYES[1 - blind]
    expected = by_hand(eye, (-1.0, 0.2, -0.1), FACE)
    assert eye_gaze(np.array(EYES), directions, np.array(FACE)) == pytest.approx(expected)


def test_no_eye_no_gaze() -> None:
    nowhere = np.full((2, 3), np.nan)
    assert np.isnan(eye_gaze(nowhere, np.array(EYES), np.array(FACE)))
    assert np.isnan(eye_gaze(np.array(EYES), nowhere, np.array(FACE)))
    assert np.isnan(eye_gaze(np.array(EYES), np.zeros((2, 3)), np.array(FACE)))


@given(st.floats(0.3, 3), st.floats(-1, 1), st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
def test_eyes_that_look_where_the_head_points_agree_with_it(
    x: float, y: float, yaw: float, pitch: float
) -> None:
    head = (x, y, 1.5)
    out = matrix(math.pi + yaw, pitch)[:, 0]
    ray = (float(out[0]), float(out[1]), float(out[2]))
    eyes = of_eyes((head, head), (ray, ray))
    assert eyes == pytest.approx(of_head(head, quaternion(math.pi + yaw, pitch)), abs=1e-7)


def test_where_a_ray_pierces_the_plane() -> None:
    face = (0.5, 9.0, 9.0)
    ahead = (2.0, 1.0, 1.5)
    assert pierce(ahead, (-1.0, -0.5, -0.25), face) == pytest.approx((0.5, 0.25, 1.125))
    for away in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]:
        assert np.isinf(pierce(ahead, away, face)).all()
    assert np.isnan(pierce(ahead, (math.nan, 0.0, 0.0), face)).all()


@pytest.mark.parametrize("x", [0.5, 0.4, -3.0])
@pytest.mark.parametrize("way", [(-1.0, 0.0, 0.0), (1.0, 0.2, 0.1), (1.0, 0.0, 0.0)])
def test_who_stands_behind_the_robots_face_cannot_look_at_it(x: float, way: Vec3) -> None:
    behind, face = (x, 0.0, 1.2), (0.5, 0.0, 1.2)
    assert np.isinf(pierce(behind, way, face)).all()
    assert of_eyes((behind, behind), (way, way), face) == GAZE_CEILING
    assert of_head(behind, quaternion(math.atan2(way[1], way[0])), face) == GAZE_CEILING


# ---- which of the two


@pytest.mark.parametrize(
    ("distance", "expected"),
    [(0.3, 0.2), (1.5, 0.2), (1.75, 0.4), (2.0, 0.6), (2.25, 0.8), (2.5, 1.0), (9.0, 1.0)],
)
def test_eyes_near_head_far_and_a_straight_line_between(distance: float, expected: float) -> None:
    assert blend(0.2, 1.0, distance) == pytest.approx(expected)


@given(st.floats(0, 2), st.floats(0, 2), st.floats(0.5, 4), st.floats(0, 1e-6))
def test_the_hand_over_has_no_steps(eye: float, head: float, at: float, step: float) -> None:
    assert blend(eye, head, at + step) == pytest.approx(blend(eye, head, at), abs=1e-5)
    between = sorted((eye, head))
    assert between[0] - 1e-12 <= blend(eye, head, at) <= between[1] + 1e-12


def test_what_is_unknown_leaves_the_decision_to_the_other_but_far_eyes_never_decide() -> None:
    for distance in (0.5, 2.0):
        assert blend(0.3, math.nan, distance) == 0.3
    assert math.isnan(blend(0.3, math.nan, 2.6))
    for distance in (0.5, 2.0, 2.6, math.nan):
        assert blend(math.nan, 0.7, distance) == 0.7
    assert math.isnan(blend(math.nan, math.nan, 1.0))


# ---- smile


def test_smile_is_the_mean_of_the_two_action_units_within_0_and_5() -> None:
    au06: FloatArray = np.array([0.0, 1.0, 5.0, 6.0, -1.0, np.nan, 2.0])
    au12: FloatArray = np.array([0.0, 4.0, 5.0, 6.0, -1.0, 3.0, np.nan])
    np.testing.assert_array_equal(smile(au06, au12), [0, 2.5, 5, 5, 0, np.nan, np.nan])
