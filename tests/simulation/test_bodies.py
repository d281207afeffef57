"""Simulated bodies: bones that keep their length, limbs that move as limbs do."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kendon.errors import ParameterError, UnknownNameError
from kendon.person import JOINTS, FloatArray
from kendon.simulation.body import FACE_HEIGHT, Body, draw_body
from kendon.simulation.limbs import Arm, blend, hang, min_jerk, reach, straighten
from kendon.simulation.motion import Motion, count_steps, look_along, move, move_now
from kendon.simulation.movements import MOVEMENTS, Movement, draw_movement, draw_talk, lasting
from kendon.simulation.movers import draw_mover, perform_movement

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(list(MOVEMENTS))

#: Nothing that a greeting moves is faster [m/s].
FASTEST = 6.5


def stand(body: Body, t: FloatArray, *movements: Movement) -> Motion:
    """Somebody who stands at the origin and looks along x."""
    still = np.zeros(len(t))
    return move(
        body, t, np.zeros((len(t), 2)), still, look_along(still, still), still, still, movements
    )


def walk(body: Body, t: FloatArray, speed: float, *movements: Movement) -> Motion:
    """Somebody who walks along x."""
    still, speeds = np.zeros(len(t)), np.full(len(t), speed)
    ground = np.stack([speed * t, still], axis=1)
    steps = count_steps(body, t, speeds)
    return move(body, t, ground, still, look_along(still, still), speeds, steps, movements)


def apart(motion: Motion, one: str, other: str) -> FloatArray:
    return np.asarray(np.linalg.norm(motion.joints[one] - motion.joints[other], axis=1))


def fastest(t: FloatArray, points: FloatArray) -> float:
    return float((np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(t)).max())


def frequency(t: FloatArray, values: FloatArray) -> float:
    """Where the spectrum of evenly sampled values is highest [1/s]."""
    padded = 20 * len(t)
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(t)), padded))
    return float(np.fft.rfftfreq(padded, t[1] - t[0])[np.argmax(power)])


# ---- limbs


@given(seeds)
def test_a_wrist_within_reach_is_reached_and_one_beyond_is_reached_for(seed: int) -> None:
    rng = np.random.default_rng(seed)
    upper, fore = rng.uniform(0.2, 0.4, 2)
    wrist = rng.normal(0, 0.3, (3, 20))
    pole = tuple(rng.normal(0, 1, 3).tolist())
    x, y, z = wrist
    elbow, reached = np.array(straighten(reach((x, y, z), pole, upper, fore), upper, fore))
    # One by one, from plain numbers, it is the same.
    x, y, z = wrist[:, 0].tolist()
    one = straighten(reach((x, y, z), pole, float(upper), float(fore)), float(upper), float(fore))
    np.testing.assert_allclose(one, [elbow[:, 0], reached[:, 0]], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(elbow, axis=0), upper, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(reached - elbow, axis=0), fore, atol=1e-9)
    span = np.linalg.norm(wrist, axis=0)
    within = (span < 0.99 * (upper + fore)) & (span > 0.7 * (upper + fore))
    np.testing.assert_allclose(reached[:, within], wrist[:, within], atol=1e-9)
    np.testing.assert_allclose(reached / np.linalg.norm(reached, axis=0), wrist / span, atol=1e-9)


def test_the_elbow_is_where_the_pole_points() -> None:
    for pole in ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (0.0, -1.0, -1.0)):
        arm = reach((0.4, 0.0, 0.0), pole, 0.3, 0.25)
        elbow = straighten(arm, 0.3, 0.25)[0]
        aside = np.array(elbow) - [elbow[0], 0, 0]
        wanted = np.array(pole) / np.linalg.norm(pole)
        np.testing.assert_allclose(aside / np.linalg.norm(aside), wanted, atol=1e-9)


def test_a_hanging_arm_points_down_and_its_elbow_bends_forward() -> None:
    straight = hang(0.0, 0.0, 0.0)
    np.testing.assert_allclose(straighten(straight, 0.3, 0.2)[1], [0, 0, -0.5], atol=1e-12)
    bent = hang(0.0, 0.0, math.pi / 2)
    np.testing.assert_allclose(straighten(bent, 0.3, 0.2)[1], [0.2, 0, -0.3], atol=1e-12)
    forward = hang(0.3, 0.0, 0.0)
    assert straighten(forward, 0.3, 0.2)[1][0] == pytest.approx(0.5 * math.sin(0.3))
    outward = hang(0.0, 0.3, 0.0)
    assert straighten(outward, 0.3, 0.2)[1][1] == pytest.approx(0.5 * math.sin(0.3))


def test_blending_goes_from_one_arm_to_the_other_by_the_middle() -> None:
    down, ahead = hang(0.0, 0.0, 0.0), hang(math.pi / 2, 0.0, 1.0)
    for weight, angle in ((0.0, 0.0), (0.5, math.pi / 4), (1.0, math.pi / 2)):
        arm: Arm = blend(down, ahead, weight)
        elbow = straighten(arm, 1.0, 1.0)[0]
        np.testing.assert_allclose(elbow, [math.sin(angle), 0, -math.cos(angle)], atol=1e-9)
        assert arm.elbow == weight


def test_min_jerk_is_at_rest_at_both_ends() -> None:
    x = np.linspace(0, 1, 10001)
    speed = np.gradient(min_jerk(x), x)
    assert abs(speed[0]) < 1e-4 > abs(speed[-1])
    assert speed.max() == pytest.approx(1.875, abs=1e-3)  # Flash & Hogan: 1.875 times the mean


# ---- standing and walking


@given(seeds)
def test_who_does_nothing_stands_upright_with_hanging_arms(seed: int) -> None:
    body = draw_body(np.random.default_rng(seed))
    t = np.arange(0, 10, 0.1)
    motion = stand(body, t)
    for side, sign in (("l", 1), ("r", -1)):
        shoulder, elbow, wrist, hip = (
            motion.joints[f"{side}_{j}"] for j in ("shoulder", "elbow", "wrist", "hip")
        )
        assert (np.abs(shoulder[:, 0] - hip[:, 0]) < 0.12 * body.torso + 0.01).all()
        assert (sign * (shoulder[:, 1] - hip[:, 1]) > 0).all()
        assert (elbow[:, 2] < shoulder[:, 2] - 0.9 * body.upper_arm).all()
        assert (wrist[:, 2] < elbow[:, 2] - 0.8 * body.forearm).all()
        assert (wrist[:, 0] > elbow[:, 0]).all()
        assert (sign * wrist[:, 1] > 0).all()
    np.testing.assert_allclose(motion.head[:, 2], FACE_HEIGHT * body.stature, atol=0.02)
    assert np.ptp(motion.head[:, :2], axis=0).max() < 0.12
    assert fastest(t, motion.head) < 0.15


def test_the_measures_are_those_of_the_literature() -> None:
    body = Body(stature=1.8)
    t = np.zeros(1)
    motion = stand(replace(body, sway=0.0, stoop=0.0), t)
    assert motion.joints["l_shoulder"][0, 2] == pytest.approx(0.818 * 1.8)
    assert motion.joints["r_hip"][0, 2] == pytest.approx(0.530 * 1.8)
    assert apart(motion, "l_shoulder", "l_elbow")[0] == pytest.approx(0.186 * 1.8)
    assert apart(motion, "r_elbow", "r_wrist")[0] == pytest.approx(0.146 * 1.8)
    assert motion.head[0] == pytest.approx([0.055 * 1.8, 0, 0.903 * 1.8])


@given(seeds, st.floats(0.9, 1.7))
def test_walkers_step_at_the_rate_of_people_and_swing_their_arms_against_each_other(
    seed: int, speed: float
) -> None:
    body = replace(draw_body(np.random.default_rng(seed), stature=1.7), pace=1.0)
    assert 1.5 < body.steps_per_second(speed) < 2.15
    t = np.arange(0, 10, 0.02)
    motion = walk(body, t, speed)
    height = motion.head[:, 2]
    assert frequency(t, height) == pytest.approx(body.steps_per_second(speed), rel=0.03)
    assert 0.015 < np.ptp(height) < 0.08
    swings = []
    for side in "lr":
        ahead = motion.joints[f"{side}_wrist"][:, 0] - motion.joints[f"{side}_shoulder"][:, 0]
        assert frequency(t, ahead) == pytest.approx(body.steps_per_second(speed) / 2, rel=0.05)
        swings.append(ahead - ahead.mean())
    assert np.corrcoef(swings)[0, 1] < -0.9
    legs = motion.joints["l_hip"][:, 0] - motion.joints["r_hip"][:, 0]
    assert np.corrcoef(legs, swings[0])[0, 1] < -0.9


# ---- movements


@given(seeds, kinds, st.sampled_from([0.0, 1.3]))
def test_bones_keep_their_length_whatever_is_done(seed: int, kind: str, speed: float) -> None:
    rng = np.random.default_rng(seed)
    body = draw_body(rng)
    movement = draw_movement(kind, rng, begin=0.5, handed=body.handed)
    motion = walk(body, np.arange(0, movement.end + 0.5, 0.05), speed, movement)
    bones = {
        ("l_shoulder", "r_shoulder"): 2 * body.half_shoulders,
        ("l_hip", "r_hip"): 2 * body.half_hips,
    }
    for side in "lr":
        bones[f"{side}_shoulder", f"{side}_elbow"] = body.upper_arm
        bones[f"{side}_elbow", f"{side}_wrist"] = body.forearm
    for (one, other), length in bones.items():
        np.testing.assert_allclose(apart(motion, one, other), length, atol=1e-9)
    middles = [
        (motion.joints[f"l_{joint}"] + motion.joints[f"r_{joint}"]) / 2
        for joint in ("shoulder", "hip")
    ]
    np.testing.assert_allclose(np.linalg.norm(middles[0] - middles[1], axis=1), body.torso)
    np.testing.assert_allclose(np.linalg.norm(motion.head_rotation, axis=1), 1)


@given(seeds, kinds, st.sampled_from([0.0, 1.3]))
def test_movements_begin_and_end_in_rest_and_nothing_jumps(
    seed: int, kind: str, speed: float
) -> None:
    rng = np.random.default_rng(seed)
    body = draw_body(rng)
    movement = draw_movement(kind, rng, begin=0.5, handed=body.handed)
    t = np.arange(0, movement.end + 0.5, 0.01)
    moved, plain = walk(body, t, speed, movement), walk(body, t, speed)
    outside = (t < movement.begin) | (t >= movement.end)
    for name in JOINTS:
        np.testing.assert_allclose(
            moved.joints[name][outside], plain.joints[name][outside], atol=1e-9
        )
        assert fastest(t, moved.joints[name]) < FASTEST
        # Continuous in speed, too: no joint is thrown about within a hundredth of a second.
        speeds = np.diff(moved.joints[name], axis=0) / 0.01
        assert np.linalg.norm(np.diff(speeds, axis=0), axis=1).max() < 2.0
    np.testing.assert_allclose(moved.head[outside], plain.head[outside], atol=1e-9)
    assert fastest(t, moved.head) < 4.5


@given(seeds)
def test_waving_wrists_swing_sideways_at_the_rate_and_by_the_size(seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = draw_body(rng)
    drawn = draw_movement("wave", rng, begin=0.0, handed=body.handed)
    movement = lasting(drawn, drawn.rise + drawn.fall + 6 / drawn.rate)
    t = np.arange(movement.rise + 0.5 / movement.rate, movement.end - movement.fall, 0.01)
    motion = stand(replace(body, sway=0.0), t, movement)
    for side in movement.hands:
        wrist = motion.joints[f"{side}_wrist"]
        assert frequency(t, wrist[:, 1]) == pytest.approx(movement.rate, rel=0.08)
        middle = np.abs(t - t.mean()) < 1.5 / movement.rate
        assert np.ptp(wrist[middle, 1]) == pytest.approx(movement.size, rel=0.25)
        shoulder = motion.joints[f"{side}_shoulder"][:, 2]
        assert (wrist[:, 2] > shoulder - 0.1).all()
    assert movement.gesture == "dsal"


@given(seeds)
def test_a_hand_is_held_out_at_the_height_of_hands_and_shaken_up_and_down(seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = draw_body(rng)
    drawn = draw_movement("handshake", rng, handed=body.handed)
    movement = replace(drawn, duration=drawn.rise + drawn.wait + drawn.fall + 6 / drawn.rate)
    begin, end = movement.rise + movement.wait, movement.duration - movement.fall
    t = np.arange(movement.rise, end, 0.01)
    motion = stand(replace(body, sway=0.0), t, movement)
    side = movement.hands[0]  # or both
    wrist = motion.joints[f"{side}_wrist"]
    assert (wrist[:, 0] - motion.joints[f"{side}_shoulder"][:, 0] > 0.2).all()
    # Very tall people do not reach down so far.
    highest = max(1.2, 0.818 * body.stature - 0.7 * body.reach + 0.05)
    assert 0.9 < wrist[:, 2].min() < wrist[:, 2].max() < highest + 1e-9
    shaken = t >= begin
    assert frequency(t[shaken], wrist[shaken, 2]) == pytest.approx(movement.rate, rel=0.08)
    assert np.ptp(wrist[shaken, 2]) == pytest.approx(movement.size, rel=0.15)
    waiting = t < begin
    if waiting.any():
        assert np.ptp(wrist[waiting], axis=0).max() < 0.01
    assert movement.gesture == "csal"


@given(seeds, st.sampled_from(["nod", "toss", "dip", "bow"]))
def test_heads_go_down_or_up_by_the_size(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    body = draw_body(rng)
    movement = draw_movement(kind, rng)
    t = np.arange(0, movement.end, 0.001)
    motion = stand(body, t, movement)
    x, y, z, w = motion.head_rotation.T
    down = np.arcsin(np.clip(2 * (w * y - x * z), -1, 1))
    np.testing.assert_allclose(2 * (x * y + w * z), 0, atol=1e-12)  # neither turned nor tilted
    furthest = -down.min() if kind == "toss" else down.max()
    most = 1.0 if kind in ("toss", "dip", "bow") else 0.7
    assert most * movement.size * 0.95 < furthest <= movement.size * 1.001
    if kind in ("dip", "bow"):
        assert motion.head[:, 2].min() < motion.head[0, 2] - 0.015
    if kind == "bow":
        shoulder, hip = motion.joints["l_shoulder"], motion.joints["l_hip"]
        lean = np.arctan2(shoulder[:, 0] - hip[:, 0], shoulder[:, 2] - hip[:, 2])
        assert lean.max() - body.stoop == pytest.approx(movement.size, abs=0.02)
    assert fastest(t, down[:, None]) < math.radians(450)


def test_what_movements_mean() -> None:
    rng = np.random.default_rng(0)
    gestures = {kind: draw_movement(kind, rng).gesture for kind in MOVEMENTS}
    assert {k for k, g in gestures.items() if g == "dsal"} == {
        "wave",
        "raise",
        "nod",
        "toss",
        "bow",
    }
    assert {k for k, g in gestures.items() if g == "csal"} == {"handshake", "hug"}
    assert {k for k, g in gestures.items() if g == "hdip"} == {"dip"}
    assert draw_movement("wave", rng, near=True).gesture == "csal"
    assert draw_movement("dip", rng, near=True).gesture == "hdip"
    assert draw_movement("talk", rng, near=True).gesture == ""


@given(seeds, kinds, st.floats(0.2, 6))
def test_movements_fit_into_the_time_they_get(seed: int, kind: str, seconds: float) -> None:
    drawn = draw_movement(kind, np.random.default_rng(seed))
    fitted = lasting(drawn, seconds)
    if drawn.hands:  # arms keep the time they need
        least = drawn.rise + drawn.fall + (1 / drawn.rate if drawn.rate else 0.1)
        assert fitted.duration == pytest.approx(max(seconds, least))
    elif kind in ("toss", "bow"):
        assert fitted.duration == min(seconds, drawn.duration)
    else:
        assert fitted.duration == seconds
    assert fitted.size <= drawn.size


def test_frames_one_by_one_are_those_of_the_whole_track() -> None:
    body = draw_body(np.random.default_rng(1))
    movements = [
        draw_movement(kind, np.random.default_rng(2), begin=begin)
        for kind, begin in (("wave", 0.3), ("dip", 2.0), ("handshake", 3.0), ("hug", 9.0))
    ]
    t = np.arange(0, 12, 0.1)
    whole = stand(body, t, *movements)
    for i, stamp in enumerate(t.tolist()):
        look = (0.0, 0.0, 0.0, 1.0)
        one = move_now(body, stamp, 0.0, 0.0, 0.0, look, 0.0, 0.0, movements)
        np.testing.assert_allclose(one.head, whole.head[i], atol=1e-12)
        np.testing.assert_allclose(one.head_rotation, whole.head_rotation[i], atol=1e-12)
        assert list(one.joints) == list(JOINTS)
        for name in JOINTS:
            np.testing.assert_allclose(one.joints[name], whole.joints[name][i], atol=1e-12)


def test_left_and_right_are_mirror_images() -> None:
    body, t = Body(sway=0.0), np.arange(0, 3, 0.05)
    left = Movement("wave", 0.2, 2.5, hands="l", size=0.3, rate=2.0, height=0.5)
    one, other = stand(body, t, left), stand(body, t, replace(left, hands="r"))
    for joint in ("shoulder", "elbow", "wrist", "hip"):
        np.testing.assert_allclose(
            one.joints[f"l_{joint}"], other.joints[f"r_{joint}"] * [1, -1, 1], atol=1e-12
        )


# ---- people who perform them


@settings(max_examples=60)
@given(seeds)
def test_movers_are_tracks_with_the_truth_of_each_frame(seed: int) -> None:
    performance = draw_mover(np.random.default_rng(seed))
    track = performance.track
    assert 8 < 1 / np.median(np.diff(track.t)) < 65
    assert set(track.joints) == set(JOINTS)
    assert np.isnan(track.gestures).all()
    assert performance.truth.shape == (len(track), 3)
    for points in (*track.joints.values(), track.head):
        assert np.isfinite(points).all()
        assert fastest(track.t, points) < FASTEST + 1.6
    shown = [m for m in performance.movements if m.gesture]
    # At most one salutation, and a head dip after it.
    assert [m.kind for m in shown[1:]] in ([], ["dip"])
    for movement in shown:
        column = ("dsal", "csal", "hdip").index(movement.gesture)
        during = (track.t >= movement.begin) & (track.t < movement.end)
        np.testing.assert_array_equal(performance.truth[:, column], during)
    if shown:
        assert track.name == shown[0].kind
    assert performance.truth.sum(axis=1).max() <= 1
    if not shown:
        assert not performance.truth.any()


def test_hands_are_shaken_near_a_robot_that_is_faced() -> None:
    rng = np.random.default_rng(0)
    for _ in range(30):
        performance = perform_movement("handshake", rng, 30.0)
        held = performance.truth[:, 1] == 1
        distance = np.hypot(*performance.track.head[held, :2].T)
        assert distance.max() < 1.8
        # The hand that is held out is the part of the person nearest to the robot.
        movement = performance.movements[-1]
        out = performance.track.t > movement.begin + movement.rise
        out &= performance.track.t < movement.end - movement.fall
        joints = performance.track.joints
        hand, shoulder = (joints[f"{movement.hands}_{part}"] for part in ("wrist", "shoulder"))
        far = [np.hypot(*part[out, :2].T) for part in (hand, shoulder, performance.track.head)]
        assert (far[0] < far[1] - 0.2).all()
        assert (far[0] < far[2]).all()


@given(seeds)
def test_who_talks_makes_phrases_one_after_another(seed: int) -> None:
    phrases = draw_talk(np.random.default_rng(seed), begin=1.0, handed="r")
    assert {m.kind for m in phrases} <= {"talk", "offer"}
    assert all(m.gesture == "" for m in phrases)
    assert min(m.begin for m in phrases) == 1.0
    # But for the hands that rest before the belly all the while.
    last = max(m.end for m in phrases)
    turns = phrases[1:] if len(phrases) > 1 and phrases[0].end > last - 1e-9 else phrases
    for one, later in itertools.pairwise(turns):
        assert one.end - 0.5 * one.fall - 1e-9 <= later.begin <= one.end + 2.5


@given(seeds)
def test_a_hand_is_offered_so_far_toward_the_partner_and_taken_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = replace(draw_body(rng), sway=0.0)
    movement = draw_movement("offer", rng, handed=body.handed)
    t = np.arange(0, movement.end, 0.01)
    motion = stand(body, t, movement)
    for side in movement.hands:
        away = np.linalg.norm(
            motion.joints[f"{side}_wrist"] - motion.joints[f"{side}_shoulder"], axis=1
        )
        out = (t > movement.rise) & (t < movement.end - movement.fall)
        assert away[out] == pytest.approx(min(movement.size, body.reach), abs=0.05)
    assert movement.gesture == ""


def test_a_seed_gives_the_same_mover() -> None:
    one, other = (draw_mover(np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one.track.head, other.track.head)
    assert one.movements == other.movements


# ---- mistakes


@pytest.mark.parametrize(
    ("part", "reason"),
    [
        ({"stature": 0.0}, "stature must be positive"),
        ({"stature": math.nan}, "stature must be positive"),
        ({"arms": -1.0}, "arms must be positive"),
        ({"handed": "both"}, "preferred hand is l or r"),
    ],
)
def test_impossible_bodies_are_refused(part: dict[str, Any], reason: str) -> None:
    with pytest.raises(ParameterError, match=reason):
        Body(**part)


@pytest.mark.parametrize(
    "part",
    [{"rise": 0.0}, {"duration": 0.5}, {"begin": math.nan}, {"rate": -1.0}, {"hands": "x"}],
)
def test_impossible_movements_are_refused(part: dict[str, Any]) -> None:
    whole: dict[str, Any] = {"kind": "wave", "begin": 0.0, "duration": 2.0, **part}
    with pytest.raises(ParameterError):
        Movement(**whole)


def test_unknown_movements_are_answered_with_the_known_ones() -> None:
    rng = np.random.default_rng(0)
    for ask in (
        lambda: Movement("curtsy", 0.0, 1.0),
        lambda: draw_movement("curtsy", rng),
        lambda: perform_movement("curtsy", rng),
    ):
        with pytest.raises(UnknownNameError, match="handshake"):
            ask()
    with pytest.raises(UnknownNameError, match="dsal"):
        Movement("wave", 0.0, 1.0, gesture="salute")
    with pytest.raises(ParameterError, match="frames a second"):
        perform_movement("wave", rng, 0.0)
