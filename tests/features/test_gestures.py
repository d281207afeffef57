"""Gestures read from bodies: written out in closed form, drawn ones, and recorded people."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from people import quaternion, tracks
from shared_data import shared_files

from kendon import Sampler, load_model, observe, read_track
from kendon.features.gestures import GestureDetector, Gestures
from kendon.features.gestures.head import Head
from kendon.features.track import watch
from kendon.observations import FEATURES
from kendon.person import GESTURES, FloatArray, Track
from kendon.phases import Phase
from kendon.simulation import sensor
from kendon.simulation.movers import draw_mover, perform_movement
from kendon.simulation.sensors import draw_sensor

RATES = (10.0, 15.0, 30.0, 60.0)
DSAL, CSAL, HDIP = (FEATURES.index(name) for name in GESTURES)
ARM, FOREARM = 0.31, 0.25

Path3 = Callable[[FloatArray], FloatArray]  # of a time (T,) to (T, 3)


def body(
    rate: float = 30.0,
    seconds: float = 4.0,
    distance: float = 4.0,
    *,
    right_elbow: Path3 | None = None,
    right_wrist: Path3 | None = None,
    left_wrist: Path3 | None = None,
    pitch: Callable[[FloatArray], FloatArray] | None = None,
    lean: Callable[[FloatArray], FloatArray] | None = None,
) -> Track:
    """Somebody 1.7 m tall who stands before a robot and faces it.

    Places of elbows and wrists are from their shoulder: x ahead of the person, y to their left, z
    up. The pitch of the head is down, the lean of the trunk forward [rad].
    """
    t = np.arange(0.0, seconds, 1 / rate)
    zero = np.zeros_like(t)
    bent = lean(t) if lean else zero

    def place(ahead: FloatArray, left: FloatArray, up: FloatArray) -> FloatArray:
        # Facing the robot, ahead is toward it and the person's left is its right.
        return np.stack([distance - ahead, -left, up], axis=1)

    def offset(path: Path3 | None, hanging: tuple[float, float, float]) -> FloatArray:
        x, y, z = (path(t) if path else np.tile(hanging, (len(t), 1))).T
        return np.stack([-x, -y, z], axis=1)

    joints = {}
    for side, left in (("l", 0.18), ("r", -0.18)):
        joints[f"{side}_hip"] = place(zero, zero + left / 2, zero + 0.9)
        shoulder = place(0.49 * np.sin(bent), zero + left, 0.9 + 0.49 * np.cos(bent))
        elbow = right_elbow if side == "r" else None
        wrist = right_wrist if side == "r" else left_wrist
        joints[f"{side}_shoulder"] = shoulder
        joints[f"{side}_elbow"] = shoulder + offset(elbow, (0.0, left / 4, -ARM))
        joints[f"{side}_wrist"] = shoulder + offset(wrist, (0.05, left / 4, -ARM - FOREARM))
    down = pitch(t) if pitch else zero
    return Track.build(
        t,
        place(0.1 + 0.64 * np.sin(bent), zero, 0.9 + 0.64 * np.cos(bent)),
        head_rotation=np.array(
            [quaternion(math.pi, d + b) for d, b in zip(down, bent, strict=True)]
        ),
        joints=joints,
    )


def risen(t: FloatArray, begin: float, seconds: float = 0.3) -> FloatArray:
    """From 0 to 1 smoothly."""
    share = np.clip((t - begin) / seconds, 0, 1)
    return np.asarray(share * share * (3 - 2 * share))


def between(t: FloatArray, low: Iterable[float], high: FloatArray, share: FloatArray) -> FloatArray:
    return np.array(list(low)) * (1 - share)[:, None] + high * share[:, None]


def waving(begin: float, end: float, hertz: float = 2.0, **more: Any) -> Track:
    """The right hand goes up within 0.3 s of `begin` and swings beside the head until `end`."""

    def share(t: FloatArray) -> FloatArray:
        return risen(t, begin) - risen(t, end)

    def elbow(t: FloatArray) -> FloatArray:
        high = np.tile([0.15, -0.27, -0.05], (len(t), 1))
        return between(t, (0.0, -0.045, -ARM), high, share(t))

    def wrist(t: FloatArray) -> FloatArray:
        angle = 0.5 * np.sin(2 * math.pi * hertz * (t - begin))
        high = np.stack(
            [0 * t + 0.15, -0.27 + FOREARM * np.sin(angle), -0.05 + FOREARM * np.cos(angle)], axis=1
        )
        return between(t, (0.05, -0.045, -ARM - FOREARM), high, share(t))

    return body(right_elbow=elbow, right_wrist=wrist, **more)


def shaking(begin: float, **more: Any) -> Track:
    """The right hand is held out to the robot from 0.4 s after `begin`, and shaken at 3 Hz."""

    def elbow(t: FloatArray) -> FloatArray:
        high = np.tile([0.22, 0.0, -0.21], (len(t), 1))
        return between(t, (0.0, -0.045, -ARM), high, risen(t, begin, 0.4))

    def wrist(t: FloatArray) -> FloatArray:
        shake = 0.03 * np.sin(6 * math.pi * t) * (t > begin + 0.6)
        high = np.stack([0 * t + 0.46, 0 * t + 0.05, -0.2 + shake], axis=1)
        return between(t, (0.05, -0.045, -ARM - FOREARM), high, risen(t, begin, 0.4))

    return body(right_elbow=elbow, right_wrist=wrist, **more)


def walking(swing: float = 0.6, **more: Any) -> Track:
    """Arms that swing straight from the shoulders once a second, against each other."""

    def arm(sign: int, length: float) -> Path3:
        def path(t: FloatArray) -> FloatArray:
            angle = sign * swing * np.sin(2 * math.pi * t)
            return np.stack(
                [length * np.sin(angle), 0 * t - 0.05 * sign, -length * np.cos(angle)], axis=1
            )

        return path

    return body(
        right_elbow=arm(1, ARM), right_wrist=arm(1, ARM + FOREARM),
        left_wrist=arm(-1, ARM + FOREARM), **more,
    )  # fmt: skip


def detected(track: Track) -> dict[str, FloatArray]:
    """Every gesture at the ends of the intervals, and those ends."""
    detector = GestureDetector()
    ends, found = [], []
    for question, _ in watch(track, detector):
        ends.append(question.end)
        found.append(detector.gestures(*question))
    columns = np.array(found).reshape(-1, len(Gestures._fields)).T
    return {"t": np.array(ends), **dict(zip(Gestures._fields, columns, strict=True))}


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("hertz", [1.0, 2.0, 3.0])
def test_a_wave_is_read_from_half_raised_to_half_lowered_within_an_interval(
    rate: float, hertz: float
) -> None:
    """The hand is half up at 1.65 s and half down at 3.65 s."""
    found = detected(waving(1.5, 3.5, hertz, rate=rate, seconds=5.0))
    t, dsal = found["t"], found["dsal"]
    assert (dsal[t <= 1.65] < 0.1).all()
    assert (dsal[(t >= 1.85) & (t <= 3.65)] > 0.6).all()
    assert (dsal[t >= 3.75] < 0.2).all()
    assert (found["csal"] < 0.2).all()


@pytest.mark.parametrize("rate", RATES)
def test_a_handshake_is_read_where_the_robot_is_within_reach(rate: float) -> None:
    near = detected(shaking(1.5, rate=rate, distance=1.0))
    late = near["t"] >= 1.9  # the hand is half out at 1.7 s
    assert (near["csal"][late] > 0.8).all()
    assert (near["csal"][near["t"] <= 1.5] < 0.1).all()
    assert (near["dsal"] < 0.3).all()
    assert (detected(shaking(1.5, rate=rate, distance=3.0))["csal"] < 0.15).all()


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("distance", [1.5, 2.0, 5.0])
def test_who_stands_or_walks_with_swinging_arms_salutes_nobody(
    rate: float, distance: float
) -> None:
    for track in (body(rate, distance=distance), walking(rate=rate, distance=distance)):
        found = detected(track)
        for name in GESTURES:
            assert (found[name] < 0.3).all(), name


@pytest.mark.parametrize("rate", RATES)
def test_a_dip_is_read_while_the_head_is_down_and_a_bow_is_none(rate: float) -> None:
    def dipped(t: FloatArray) -> FloatArray:
        return math.radians(38) * (risen(t, 2.0, 0.15) - risen(t, 2.7, 0.15))

    dip = detected(body(rate, pitch=dipped))
    down = (dip["t"] >= 2.35) & (dip["t"] <= 2.7)
    assert (dip["hdip"][down] > 0.6).all()
    assert (dip["hdip"][(dip["t"] <= 2.0) | (dip["t"] >= 3.1)] < 0.1).all()
    assert not (dip["nod"] > 0.5).any()
    assert (dip["csal"] < 0.2).all()

    def bent(t: FloatArray) -> FloatArray:
        return math.radians(40) * (risen(t, 2.0, 0.5) - risen(t, 3.2, 0.5))

    for distance, name in ((4.0, "dsal"), (1.0, "csal")):
        bow = detected(body(rate, distance=distance, lean=bent))
        deep = (bow["t"] >= 2.7) & (bow["t"] <= 3.2)
        assert (bow[name][deep] > 0.8).all()
        assert (bow["hdip"] < 0.3).all()


def test_a_bow_is_no_dip_where_the_hips_are_not_seen_either() -> None:
    def bent(t: FloatArray) -> FloatArray:
        return math.radians(40) * (risen(t, 2.0, 0.5) - risen(t, 3.2, 0.5))

    def dipped(t: FloatArray) -> FloatArray:
        return math.radians(38) * (risen(t, 2.0, 0.15) - risen(t, 2.7, 0.15))

    def without_hips(track: Track) -> Track:
        return replace(track, joints={n: p for n, p in track.joints.items() if "hip" not in n})

    bow = detected(without_hips(body(lean=bent)))
    deep = (bow["t"] >= 2.7) & (bow["t"] <= 3.2)
    assert (bow["dsal"][deep] > 0.8).all()
    assert (bow["hdip"][deep] < 0.3).all()  # nobody can tell them apart while they begin
    dip = detected(without_hips(body(pitch=dipped)))
    down = (dip["t"] >= 2.35) & (dip["t"] <= 2.7)
    assert (dip["hdip"][down] > 0.6).all()
    assert not (dip["bow"] > 0.3).any()


@pytest.mark.parametrize("joint", ["head", "r_shoulder", "r_wrist", "r_elbow"])
def test_places_beyond_all_measure_are_unknown(joint: str) -> None:
    track = waving(1.0, 4.0)
    wild = (track.t > 1.5) & (track.t < 1.7)
    places = track.head if joint == "head" else track.joints[joint]
    endless = np.where(wild[:, None], np.array([1.0, 1.0, math.inf]), places)
    if joint == "head":
        seen = detected(replace(track, head=endless))
    else:
        seen = detected(replace(track, joints={**track.joints, joint: endless}))
    assert seen["dsal"][-1] > 0.5


def test_a_back_turned_is_never_ahead_however_the_joints_jitter() -> None:
    rng = np.random.default_rng(0)
    head = Head()
    for k in range(60):
        yaw = math.pi + rng.normal(0, 0.05)  # from the way to the robot
        head.add(k / 30, (2.0, 0.0, 1.6), (0.0, 0.0, math.sin(yaw / 2 + math.pi / 2),
            math.cos(yaw / 2 + math.pi / 2)))  # fmt: skip
        if k > 20:
            assert head.aside(k / 30, k / 30 - 0.2) > 2.5


@pytest.mark.parametrize("rate", [15.0, 30.0, 60.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_nod_and_a_toss_speak_for_a_salutation(rate: float, sign: int) -> None:
    def beaten(t: FloatArray) -> FloatArray:
        beat = np.sin(math.pi * (t - 2.0) / 0.35) ** 2
        return sign * math.radians(16) * beat * ((t > 2.0) & (t < 2.7))

    nod, quiet = (detected(person)["nod"] for person in (body(rate, pitch=beaten), body(rate)))
    assert np.nanmax(nod) > 0.5 > 0.1 > np.nanmax(quiet)

    # Who looks aside meanwhile, looks at something.
    aside = body(rate, pitch=beaten)
    yaw = math.pi + 0.6 * np.sin(math.pi * np.clip((aside.t - 2.0) / 0.7, 0, 1))
    turned = [quaternion(y, p) for y, p in zip(yaw, beaten(aside.t), strict=True)]
    glance = detected(replace(aside, head_rotation=np.array(turned)))["nod"]
    assert np.nanmax(glance) < 0.5


@pytest.mark.parametrize("back", [0.0, 25.0])
def test_who_looks_up_from_the_ground_for_a_toss_tosses_the_head(back: float) -> None:
    """From 25 degrees down to 12 over the level, and back to the level or to the ground."""

    def tossed(t: FloatArray) -> FloatArray:
        up, down = risen(t, 2.0, 0.2), risen(t, 2.4, 0.3)
        return np.radians(25 - 37 * up + (12 + back) * down)

    looking_up = body(pitch=lambda t: np.radians(25 - 25 * risen(t, 2.0, 0.2)))
    assert np.nanmax(detected(body(pitch=tossed))["nod"]) > 0.5
    assert np.nanmax(detected(looking_up)["nod"]) < 0.1


def test_a_beat_is_told_once_and_then_no_more() -> None:
    """A nod that is over at 2.35 s."""

    def nodded(t: FloatArray) -> FloatArray:
        beat = np.sin(math.pi * (t - 2.0) / 0.35) ** 2
        return math.radians(16) * beat * ((t > 2.0) & (t < 2.35))

    found = detected(body(pitch=nodded))
    t, nod = found["t"], found["nod"]
    assert (nod[(t > 2.35) & (t < 2.6)] > 0.5).all()
    assert (nod[t > 3.05] < 0.1).all()


def test_a_wave_is_read_at_its_turning_points_too() -> None:
    """A wide slow swing, from upright to level and back."""

    def wrist(t: FloatArray) -> FloatArray:
        angle = 0.8 - 0.8 * np.cos(2 * math.pi * 1.5 * (t - 1.8))
        high = np.stack(
            [0 * t + 0.15, -0.27 - FOREARM * np.sin(angle), -0.05 + FOREARM * np.cos(angle)], axis=1
        )
        return between(t, (0.05, -0.045, -ARM - FOREARM), high, risen(t, 1.5))

    def elbow(t: FloatArray) -> FloatArray:
        high = np.tile([0.15, -0.27, -0.05], (len(t), 1))
        return between(t, (0.0, -0.045, -ARM), high, risen(t, 1.5))

    found = detected(body(right_elbow=elbow, right_wrist=wrist))
    assert (found["dsal"][found["t"] >= 2.4] > 0.6).all()


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("hands", ["together", "at the chin", "up and still"])
def test_who_talks_near_the_robot_salutes_nobody_for_long(rate: float, hands: str) -> None:
    """Hands that talk are where hands salute, or nearly, but not as they do."""
    places = {
        "together": (0.4, 0.15, -0.2),
        "at the chin": (0.12, 0.1, 0.05),
        "up and still": (0.15, -0.1, 0.12),
    }

    def wrist(t: FloatArray) -> FloatArray:
        up = np.tile(places[hands], (len(t), 1))
        return between(t, (0.05, -0.045, -ARM - FOREARM), up, risen(t, 0.5, 0.4))

    def other(t: FloatArray) -> FloatArray:
        x, y, z = places[hands]
        near = np.tile((x, -y, z), (len(t), 1))
        return between(t, (0.05, 0.045, -ARM - FOREARM), near, risen(t, 0.5, 0.4))

    both = other if hands == "together" else None
    found = detected(body(rate, 6.0, 1.0, right_wrist=wrist, left_wrist=both))
    assert (found["csal"][found["t"] >= 3.5] < 0.5).all()


@pytest.mark.parametrize("rate", [15.0, 30.0, 60.0])
@pytest.mark.parametrize("seconds", [0.3, 0.4])
def test_a_hand_that_talks_goes_out_and_back_where_one_that_greets_stays(
    rate: float, seconds: float
) -> None:
    """Held out to the robot within 0.4 s, it is taken back at once, or not."""

    def held(stays: bool) -> Track:
        def share(t: FloatArray) -> FloatArray:
            out = risen(t, 1.5, seconds)
            return out if stays else out - risen(t, 1.5 + seconds, seconds)

        def elbow(t: FloatArray) -> FloatArray:
            high = np.tile([0.22, 0.0, -0.21], (len(t), 1))
            return between(t, (0.0, -0.045, -ARM), high, share(t))

        def wrist(t: FloatArray) -> FloatArray:
            high = np.tile([0.36, 0.0, -0.15], (len(t), 1))
            return between(t, (0.05, -0.045, -ARM - FOREARM), high, share(t))

        return body(rate, 4.0, 1.0, right_elbow=elbow, right_wrist=wrist)

    stays, goes = detected(held(True)), detected(held(False))
    assert (stays["csal"][stays["t"] >= 1.5 + seconds + 0.4] > 0.6).all()
    back = goes["t"] >= 1.5 + 1.5 * seconds
    assert (goes["csal"][back] < 0.5).all()


@pytest.mark.parametrize("distance", [1.0, 4.0])
def test_a_hand_of_somebody_who_has_talked_with_it_near_by_greets_less_surely(
    distance: float,
) -> None:
    """Beats before the belly for five seconds, a rest, and then a hand is held out, or raised."""
    belly = np.array([0.25, 0.0, -0.30])

    def moves(talks: bool, to: tuple[float, float, float]) -> Track:
        def wrist(t: FloatArray) -> FloatArray:
            beat = 0.12 * np.sin(2 * math.pi * 1.2 * t)
            before = np.tile(belly, (len(t), 1)) + np.stack([beat, beat, beat], axis=1)
            down = np.tile([0.05, -0.045, -ARM - FOREARM], (len(t), 1))
            rests = risen(t, 5.0) if talks else np.ones_like(t)
            talk = before + rests[:, None] * (down - before)
            return np.asarray(talk + risen(t, 6.0, 0.4)[:, None] * (np.array(to) - talk))

        return body(30.0, 7.2, distance, right_wrist=wrist)

    for name, to in (("handshake", (0.42, 0.0, -0.15)), ("wave", (0.10, -0.2, 0.30))):
        after, alone = (detected(moves(talks, to)) for talks in (True, False))
        late = alone["t"] > 6.4
        if distance < 2.0:
            assert (after[name] < alone[name] - 0.01)[late].all()
        elif name == "wave":  # who is far talks to nobody
            assert after[name][late] == pytest.approx(alone[name][late], abs=0.02)


def test_a_wrist_in_its_own_shoulder_waves_to_nobody() -> None:
    """No elbow bends so far: something else is taken for the hand."""

    def wrist(t: FloatArray) -> FloatArray:
        up = np.stack([0 * t + 0.02, 0.05 * np.sin(9 * t), 0 * t + 0.08], axis=1)
        return between(t, (0.05, -0.045, -ARM - FOREARM), up, risen(t, 1.5))

    found = detected(body(seconds=6.0, distance=1.0, right_wrist=wrist))
    assert (found["wave"] < 0.3).all()


def test_the_nearer_the_more_a_wave_is_a_close_salutation() -> None:
    found = [detected(waving(1.0, 4.0, distance=d)) for d in (0.8, 1.1, 1.3, 1.5, 2.0)]
    dsal = [f["dsal"][-1] for f in found]
    csal = [f["csal"][-1] for f in found]
    assert dsal == sorted(dsal)
    assert csal == sorted(csal, reverse=True)
    assert csal[0] > 0.8 > 0.1 > csal[-1]
    assert dsal[-1] > 0.8 > 0.1 > dsal[0]


def test_unknown_joints_are_unknown_gestures() -> None:
    track = waving(1.0, 4.0)
    bare = replace(track, joints={}, head_rotation=np.full((len(track), 4), np.nan))
    hidden = replace(
        bare, joints={name: np.full_like(p, np.nan) for name, p in track.joints.items()}
    )
    for unknown in (bare, hidden):
        assert np.isnan(observe(unknown).values[:, [DSAL, CSAL, HDIP]]).all()
    head_only = observe(replace(track, joints={}))
    assert np.isnan(head_only.values[:, DSAL]).all()  # a still head says nothing of hands
    assert (head_only.values[:, HDIP] < 0.2).all()


def test_one_arm_is_enough() -> None:
    track = waving(1.0, 4.0)
    one = {name: points for name, points in track.joints.items() if name in ("r_wrist", "r_elbow")}
    assert observe(replace(track, joints=one)).values[-1, DSAL] > 0.5
    other = {name: p for name, p in track.joints.items() if name.startswith("l_")}
    assert observe(replace(track, joints=other)).values[-1, DSAL] < 0.2


def test_how_fresh_a_raised_hand_is_is_not_told_from_long_before_keys_were_pressed() -> None:
    track = waving(8.0, 11.0, seconds=11.0)
    pressed = np.where((track.t < 8.35)[:, None], 0.0, np.nan) * np.ones(3)
    late, plain = observe(replace(track, gestures=pressed)), observe(track)
    after = (late.t > 8.8) & (late.t < 10.8)
    assert (plain.values[after, DSAL] > 0.8).all()
    np.testing.assert_allclose(late.values[after, DSAL], plain.values[after, DSAL], atol=0.15)


def test_gestures_given_by_hand_override_one_by_one() -> None:
    track = waving(1.0, 4.0)
    given = np.tile([0.125, np.nan, np.nan], (len(track), 1))
    plain, told = observe(track).values, observe(replace(track, gestures=given)).values
    assert (told[:, DSAL] == 0.125).all()
    np.testing.assert_array_equal(told[:, [CSAL, HDIP]], plain[:, [CSAL, HDIP]])


def seen_by(track: Track, robot: FloatArray) -> Track:
    """A track of a robot at the origin as a robot that moves would see it; (T, 3) x y yaw."""
    c, s = np.cos(robot[:, 2]), np.sin(robot[:, 2])

    def move(points: FloatArray) -> FloatArray:
        x, y = points[:, 0] - robot[:, 0], points[:, 1] - robot[:, 1]
        return np.stack([c * x + s * y, -s * x + c * y, points[:, 2]], axis=1)

    x, y, z, w = track.head_rotation.T
    half_s, half_c = np.sin(-robot[:, 2] / 2), np.cos(-robot[:, 2] / 2)
    rotation = [half_c * x - half_s * y, half_c * y + half_s * x,
                half_c * z + half_s * w, half_c * w - half_s * z]  # fmt: skip
    return replace(
        track,
        head=move(track.head),
        head_rotation=np.stack(rotation, axis=1),
        joints={name: move(points) for name, points in track.joints.items()},
        robot=robot,
    )


@given(st.floats(-2, 2), st.floats(-1.5, 1.5))
@settings(max_examples=15)
def test_a_robot_that_turns_changes_nothing(rate: float, begin: float) -> None:
    for track in (waving(1.0, 3.0), shaking(1.0, distance=1.0)):
        yaw = begin + rate * track.t
        turned = seen_by(track, np.stack([0 * yaw, 0 * yaw, yaw], axis=1))
        plain, found = detected(track), detected(turned)
        for name in Gestures._fields:
            np.testing.assert_allclose(found[name], plain[name], atol=1e-6)


@given(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))
@settings(max_examples=15)
def test_a_robot_that_drives_makes_no_gesture(ahead: float, aside: float) -> None:
    track = body(seconds=3.0)
    robot = np.stack([ahead * track.t, aside * track.t, 0 * track.t], axis=1)
    found = detected(seen_by(track, robot))
    for name in GESTURES:
        assert (found[name] < 0.3).all()
    waved = waving(1.0, 3.0, seconds=3.0, distance=6.0)
    assert detected(seen_by(waved, robot))["wave"][-1] > 0.6


@pytest.mark.parametrize("kind", ["wave", "handshake", "nod", "toss", "dip", "bow"])
@given(st.integers(0, 10_000), st.floats(0.0, 0.4))
@settings(max_examples=6, deadline=None)
def test_every_gesture_is_a_probability_or_unknown(kind: str, seed: int, lost: float) -> None:
    rng = np.random.default_rng(seed)
    seen = draw_sensor(rng).see(perform_movement(kind, rng).track, rng)
    holes = {name: rng.random(len(seen)) < lost for name in seen.joints}
    joints = {n: np.where(holes[n][:, None], np.nan, p) for n, p in seen.joints.items()}
    track = replace(seen, joints=joints)
    found = detected(track)
    for name in Gestures._fields:
        values = found[name]
        assert ((values >= 0) & (values <= 1) | np.isnan(values)).all(), name
    for column, name in ((DSAL, "dsal"), (CSAL, "csal"), (HDIP, "hdip")):
        answered = np.isin(observe(track).t, found["t"])
        np.testing.assert_array_equal(observe(track).values[answered, column], found[name])


@given(tracks())
@settings(max_examples=20)
def test_the_wildest_tracks_give_probabilities_or_nothing(track: Track) -> None:
    values = observe(replace(track, gestures=np.full_like(track.gestures, np.nan))).values
    gestures = values[:, [DSAL, CSAL, HDIP]]
    assert ((gestures >= 0) & (gestures <= 1) | np.isnan(gestures)).all()


@given(st.integers(0, 10_000))
@settings(max_examples=15, deadline=None)
def test_frame_by_frame_is_the_same_as_the_whole_track(seed: int) -> None:
    track = sensor("noisy", seed)(draw_mover(np.random.default_rng(seed)).track)
    sampler = Sampler()
    rows = [row for frame in track for row in sampler.push(frame)]
    rows += sampler.advance(float(track.t[-1]) + 1e-3)
    whole = observe(track)
    live = np.array([row[1:] for row in rows])
    assert len(live) == len(whole)
    columns = [DSAL, CSAL, HDIP]
    np.testing.assert_array_equal(live[:, columns], whole.values[:, columns])


@given(st.integers(0, 10_000))
@settings(max_examples=10, deadline=None)
def test_nothing_after_an_interval_changes_it(seed: int) -> None:
    track = draw_mover(np.random.default_rng(seed)).track
    whole = observe(track).values
    rows = len(track) // 2
    first = Track.build(
        track.t[:rows], track.head[:rows], head_rotation=track.head_rotation[:rows],
        joints={name: points[:rows] for name, points in track.joints.items()},
    )  # fmt: skip
    part = observe(first).values
    done = len(part) - 1
    np.testing.assert_array_equal(part[:done, DSAL:], whole[:done, DSAL:])


def test_noise_moves_the_probability_toward_its_prior() -> None:
    def dipped(t: FloatArray) -> FloatArray:
        return math.radians(38) * (risen(t, 2.0, 0.15) - risen(t, 2.8, 0.15))

    rng = np.random.default_rng(1)
    clean = body(pitch=dipped)
    still = body()
    sure = detected(clean)["hdip"].max() - detected(still)["hdip"].max()
    noise = rng.normal(0, math.radians(40), len(clean))
    worse = [detected(body(pitch=lambda t, f=f: f(t) + noise))["hdip"].max()  # type: ignore[misc]
             for f in (dipped, np.zeros_like)]  # fmt: skip
    assert worse[0] - worse[1] < sure / 2
    assert worse[0] < detected(clean)["hdip"].max()


def test_most_drawn_waves_are_read_and_telephones_are_not() -> None:
    def share(kind: str, name: str, seeds: range) -> float:
        hits = []
        for seed in seeds:
            person = perform_movement(kind, np.random.default_rng(seed), 30.0)
            hits.append(bool((detected(person.track)[name] > 0.5).any()))
        return float(np.mean(hits))

    assert share("wave", "wave", range(20)) > 0.7
    assert share("handshake", "csal", range(20)) > 0.7
    assert share("pockets", "wave", range(20)) < 0.3
    assert share("text", "wave", range(20)) < 0.3


def test_a_dip_is_read_from_how_the_face_sinks_where_it_cannot_be_told_where_it_points() -> None:
    most: dict[str, list[float]] = {"dip": [], "wave": []}
    for kind, seed in itertools.product(most, range(20)):
        person = perform_movement(kind, np.random.default_rng(seed), 30.0)
        if kind == "wave" and person.truth[:, GESTURES.index("hdip")].any():
            continue
        blind = np.full_like(person.track.head_rotation, np.nan)
        found = detected(replace(person.track, head_rotation=blind))["hdip"]
        most[kind].append(float(np.nanmax(found)))
    assert np.median(most["dip"]) > 0.3
    assert np.median(most["wave"]) < 0.1


def test_a_wave_that_begins_afar_stays_a_distance_salutation_on_the_way() -> None:
    wave = waving(1.0, 4.0, seconds=4.5, distance=2.2)
    steps = np.zeros_like(wave.head)
    steps[:, 0] = -0.5 * np.clip(wave.t - 1.2, 0, 2.5)
    walked = replace(
        wave,
        head=wave.head + steps,
        joints={name: places + steps for name, places in wave.joints.items()},
    )
    found = detected(walked)
    near = (found["t"] > 3.4) & (found["t"] < 4.0)
    assert (np.hypot(*walked.head[:, :2].T)[walked.t > 3.4] < 1.2).all()
    assert (found["dsal"][near] > 0.5).all()
    assert (found["csal"][near] < 0.5).all()

    # Also where the hand hangs for an interval on the way.
    hangs = body(seconds=4.5, distance=2.2).joints
    down = (wave.t > 3.0) & (wave.t <= 3.2)
    joints = {
        name: np.where(down[:, None], hangs[name], places) + steps
        for name, places in wave.joints.items()
    }
    paused = detected(replace(walked, joints=joints))
    assert paused["wave"].min(where=(paused["t"] > 3.0) & (paused["t"] < 3.4), initial=1.0) < 0.2
    again = (paused["t"] > 3.5) & (paused["t"] < 4.0)
    assert (paused["dsal"][again] > 0.5).all()
    assert (paused["csal"][again] < 0.5).all()


def test_recorded_waves_and_handshakes_are_read() -> None:
    for path in shared_files("data/gestures/*.csv"):
        with path.open(newline="") as file:
            labels = np.array([row["gesture"] for row in csv.DictReader(file)])
        track = read_track(path)
        found = detected(track)
        name = "wave" if "wave" in labels else "handshake"
        middle = labels[np.searchsorted(track.t, found["t"] - 0.1)]
        assert (found[name][middle == name] > 0.5).mean() > 0.4, path.stem
        assert (found["csal"][middle == name] > 0.5).mean() > 0.6, path.stem
        assert (found["dsal"] < 0.5).all(), path.stem


def test_recorded_passers_by_greet_nobody() -> None:
    model = load_model("kendon")
    for path in shared_files("data/mocap/passerby_*.csv"):
        seen = observe(read_track(path))
        assert (seen.values[:, CSAL] < 0.5).all(), path.stem
        assert (seen.values[:, DSAL] < 0.5).all(), path.stem
        assert (model.filter(seen.values).argmax(axis=1) + 1 != Phase.CS).all(), path.stem


def test_gestures_tell_the_phases_of_recorded_greetings() -> None:
    values, phases = [], []
    for path in shared_files("data/mocap/greeting_*.csv"):
        seen = observe(read_track(path))
        assert seen.phases is not None
        values.append(seen.values)
        phases.append(seen.phases)
    for column, phase, least in (
        (DSAL, Phase.DS, 0.95),
        (CSAL, Phase.CS, 0.95),
        (HDIP, Phase.HD, 0.9),
    ):
        probability = np.concatenate(values)[:, column]
        performed = np.concatenate(phases) == phase
        pairs = itertools.product(probability[performed], probability[~performed])
        assert np.mean([yes > no for yes, no in pairs]) > least
