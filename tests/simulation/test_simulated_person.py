"""Simulated people: how they walk, what they show, and that every greeting comes to an end."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from kendon.errors import ParameterError, UnknownNameError
from kendon.features import head_gaze, observe
from kendon.geometry import ORIGIN, Pose2D, Vec3
from kendon.person import JOINTS, PersonFrame, Track
from kendon.phases import Phase
from kendon.robots import PointRobot
from kendon.simulation import SCRIPTS, Act, Script, SimulatedPerson, script
from kendon.simulation.person import PATIENCE
from kendon.sources.base import open_source
from kendon.sources.simulated import SimulatedSource

#: No greeting takes longer than this, whatever the robot does [s].
LONGEST = 120.0


class Station(NamedTuple):
    frame: PersonFrame
    phase: Phase
    position: tuple[float, float]
    robot: Pose2D


def play(
    script: Script, robot: Callable[[float], Pose2D] = lambda _: ORIGIN, rate: float = 30.0
) -> list[Station]:
    """A script to its end before a robot that stands where the function of time says."""
    person = SimulatedPerson(script, rate)
    stations = []
    while not person.finished:
        assert person.t < LONGEST
        pose = robot(person.t)
        stations.append(Station(person.frame(pose), person.phase, person.position, pose))
        person.step(pose)
    return stations


def stretches(stations: list[Station]) -> list[tuple[Phase, list[Station]]]:
    return [(phase, list(group)) for phase, group in itertools.groupby(stations, lambda s: s.phase)]


def walking(start: float = 6.0, **parts: Any) -> Script:
    """Somebody who only walks up."""
    acts = (Act(Phase.APP, until_distance=0.5, walking=True),)
    return Script(start, acts, **parts)


# ---- walking


@pytest.mark.parametrize("rate", [5.0, 10.0, 30.0])
@pytest.mark.parametrize("speed", [0.4, 1.2, 2.0])
def test_walks_straight_at_the_stated_speed(rate: float, speed: float) -> None:
    bearing = 0.7
    stations = play(walking(speed=speed, bearing=bearing), rate=rate)
    places = np.array([s.position for s in stations])
    assert places[0] == pytest.approx([6 * math.cos(bearing), 6 * math.sin(bearing)])
    np.testing.assert_allclose(np.arctan2(places[:, 1], places[:, 0]), bearing, atol=1e-9)
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    np.testing.assert_allclose(lengths[:-1], speed / rate, atol=1e-9)
    # 5 m to walk, from station to station (Algorithm 2).
    assert len(stations) == pytest.approx(5 / speed * rate, abs=1.01)
    t = [s.frame.t for s in stations]
    np.testing.assert_allclose(t, np.arange(len(t)) / rate)


@pytest.mark.parametrize("stop", [0.6, 1.0, 2.5])
def test_stops_at_the_stop_distance_before_a_robot_that_stands(stop: float) -> None:
    person = SimulatedPerson(walking(stop_distance=stop))
    while not person.finished:
        person.step()
    assert math.hypot(*person.position) == pytest.approx(stop, abs=1e-9)


@pytest.mark.parametrize("velocity", [(0.3, 0.0), (-0.5, 0.0), (0.1, 0.4), (-0.2, -0.6)])
def test_stops_at_the_stop_distance_before_a_robot_that_moves(
    velocity: tuple[float, float],
) -> None:
    def robot(t: float) -> Pose2D:
        return Pose2D(velocity[0] * t, velocity[1] * t, 0.5 * t)

    person = SimulatedPerson(walking())
    while not person.finished:
        pose = robot(person.t)
        person.step(pose)
        assert person.t < LONGEST
    gap = math.hypot(person.position[0] - pose.x, person.position[1] - pose.y)
    assert gap == pytest.approx(1.0, abs=1e-6)


def test_never_steps_nearer_than_the_stop_distance_by_itself_nor_backs_away() -> None:
    def robot(t: float) -> Pose2D:
        return Pose2D(0.8 * t, 0, 0)

    stations = play(SCRIPTS["normal"], robot)
    for before, after in itertools.pairwise(stations):
        gap = math.dist(before.position, before.robot[:2])
        moved = math.dist(before.position, after.position)
        if gap <= 1.0:
            assert moved == 0
        else:
            assert math.dist(after.position, before.robot[:2]) >= 1.0 - 1e-9


def test_the_sampler_measures_the_walking_speed() -> None:
    """Closed form: while walking, the speed feature is the script's speed, wherever it is from."""
    for bearing in (0.0, 0.6, -1.2):
        stations = play(walking(8.0, speed=1.1, bearing=bearing))
        seen = observe(Track.from_frames(s.frame for s in stations))
        np.testing.assert_allclose(seen.values[1:, 1], 1.1, atol=1e-9)


def test_a_moving_robot_does_not_change_the_persons_measured_speed() -> None:
    def robot(t: float) -> Pose2D:
        return Pose2D(0.4 * t, 0, 0)

    stations = play(walking(8.0, speed=1.1), robot)
    seen = observe(Track.from_frames(s.frame for s in stations))
    np.testing.assert_allclose(seen.values[1:, 1], 1.1, atol=1e-9)


# ---- acts

ORDER = {
    "normal": "IA APP DS HD APP FA CS",
    "plain": "IA APP FA CS",
    "late-wave": "IA APP FA DS FA CS",
    "short": "IA FA CS",
}


def test_every_script_is_tested_here() -> None:
    assert list(SCRIPTS) == list(ORDER)
    assert all(s.title for s in SCRIPTS.values())


@pytest.mark.parametrize("name", ORDER)
def test_phases_come_in_the_scripts_order_and_last_as_stated(name: str) -> None:
    parts = stretches(play(SCRIPTS[name]))
    assert " ".join(phase.name for phase, _ in parts) == ORDER[name]
    for (_, stations), act in zip(parts, SCRIPTS[name].acts, strict=True):
        distances = [math.hypot(*s.position) for s in stations]
        if math.isfinite(act.seconds):
            assert len(stations) / 30 == pytest.approx(act.seconds, abs=1.01 / 30)
        else:
            assert min(distances) > act.until_distance
            assert distances[-1] - act.until_distance <= 1.2 / 30 + 1e-6
        if not act.walking:
            assert max(distances) == min(distances)


@pytest.mark.parametrize("name", ORDER)
def test_keys_are_pressed_exactly_during_their_phases(name: str) -> None:
    for station in play(SCRIPTS[name]):
        frame = station.frame
        assert frame.dsal == (station.phase is Phase.DS)
        assert frame.csal == (station.phase is Phase.CS)
        assert frame.hdip == (station.phase is Phase.HD)


@pytest.mark.parametrize("name", ORDER)
def test_the_features_are_those_of_the_acts(name: str) -> None:
    parts = stretches(play(SCRIPTS[name]))
    for (_, stations), act in zip(parts, SCRIPTS[name].acts, strict=True):
        for station in stations:
            assert measured_gaze(station.frame, (0, 0, 1.2)) == pytest.approx(act.gaze, abs=1e-9)
            assert station.frame.smile == act.smile
            assert station.frame.head[2] == 1.6


@pytest.mark.parametrize("name", ORDER)
@pytest.mark.parametrize("drive", [0.5, -0.5, 0.0])
@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_every_script_ends_whatever_a_robot_of_ordinary_speed_does(
    name: str, drive: float, turn: float
) -> None:
    def robot(t: float) -> Pose2D:
        return Pose2D(drive * t, 0.1 * t, turn * t)

    stations = play(SCRIPTS[name], robot)
    assert stations[-1].phase is Phase.CS


# ---- the body


def moving(name: str, **parts: Any) -> tuple[Track, list[Phase]]:
    """A person without keys who plays a script to its end."""
    person = SimulatedPerson(replace(script(name), **parts), keys=False, seed=3)
    frames, phases = [], []
    while not person.finished:
        frames.append(person.frame())
        phases.append(person.phase)
        person.step()
    return Track.from_frames(frames), phases


@pytest.mark.parametrize("name", ORDER)
def test_without_keys_the_body_shows_what_the_keys_said(name: str) -> None:
    track, phases = moving(name, bearing=0.0)
    now = np.array(phases)
    assert np.isnan(track.gestures).all()
    hands = np.max([track.joints["l_wrist"][:, 2], track.joints["r_wrist"][:, 2]], axis=0)
    if Phase.DS in now:
        assert hands[now == Phase.DS].max() > track.joints["l_shoulder"][:, 2].max()
    assert hands[(now == Phase.APP) & (track.t < 1.8)].max(initial=0) < 1.1
    # The hand that is held out is nearer to the robot than anything else of the person.
    held = np.flatnonzero(now == Phase.CS)[45:75]
    nearest = np.hypot(*track.joints["r_wrist"][held, :2].T)
    assert (nearest < np.hypot(*track.head[held, :2].T) - 0.1).all()
    assert track.joints["r_wrist"][held, 2] == pytest.approx(1.05, abs=0.15)


@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 1000),
    name=st.sampled_from(list(ORDER)),
    movement=st.sampled_from([None, "", "bow", "nod", "hug", "raise", "talk"]),
)
def test_no_joint_jumps_whatever_the_acts_are(seed: int, name: str, movement: str | None) -> None:
    acts = tuple(replace(act, movement=movement) for act in SCRIPTS[name].acts)
    person = SimulatedPerson(replace(SCRIPTS[name], acts=acts), keys=False, seed=seed)
    frames = []
    while not person.finished:
        frames.append(person.frame())
        person.step()
    track = Track.from_frames(frames)
    for points in (track.head, *track.joints.values()):
        assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() * 30 < 7.5
    turns = np.abs((track.head_rotation[1:] * track.head_rotation[:-1]).sum(axis=1))
    assert 2 * np.arccos(np.clip(turns, -1, 1)).max() * 30 < math.radians(600)


#: Somebody who has hardly set off when they close in: no time to get the hand ready.
HASTY = Script(
    1.3,
    (
        Act(Phase.IA, seconds=0.6),
        Act(Phase.FA, seconds=0.1, walking=True),
        Act(Phase.CS, seconds=3.0),
    ),
)


@pytest.mark.parametrize("drive", [0.0, 0.4, -0.3])
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("played", [SCRIPTS["plain"], HASTY], ids=["plain", "hasty"])
def test_a_hand_is_half_raised_when_its_phase_begins(
    played: Script, seed: int, drive: float
) -> None:
    """Also where a phase begins at a distance, and the robot drives: hands take 0.5 to 0.9 s."""
    acts = tuple(replace(act, movement="") for act in played.acts)
    people = [
        SimulatedPerson(replace(played, acts=which), keys=False, seed=seed)
        for which in (played.acts, acts)
    ]
    raised = 0.0  # [s], when a hand leaves where it would be if it were never held out
    while people[0].phase is not Phase.CS:
        pose = Pose2D(drive * people[0].t, 0.0, 0.0)
        shakes, waits = (person.frame(pose).joints for person in people)
        if shakes["r_wrist"] == waits["r_wrist"] and shakes["l_wrist"] == waits["l_wrist"]:
            raised = people[0].t
        for person in people:
            person.step(pose)
    assert 0.25 - 1 / 30 < people[0].t - raised < 0.45 + 2 / 30


def test_a_head_that_dips_goes_down_and_comes_up_again() -> None:
    track, phases = moving("normal")
    now = np.array(phases)
    x, y, z, w = track.head_rotation.T
    down = np.arcsin(2 * (w * y - x * z))
    dip = np.flatnonzero(now == Phase.HD)
    before, most = down[dip[0] - 10], down[dip].max()  # a third of a second
    assert most > before + math.radians(20)
    assert down[dip[0]] == pytest.approx((before + most) / 2, abs=math.radians(6))  # half down
    assert down[dip[-1]] < most - math.radians(5)


def test_with_keys_the_body_hangs_under_a_head_on_rails() -> None:
    for station in play(SCRIPTS["normal"]):
        frame = station.frame
        assert frame.head == pytest.approx((*station.position, 1.6))
        assert list(frame.joints) == list(JOINTS)
        middle = np.mean([frame.joints["l_shoulder"], frame.joints["r_shoulder"]], axis=0)
        assert 0.05 < math.dist(middle, frame.head) < 0.3


def test_joints_are_seen_from_the_robot_as_the_head_is() -> None:
    robot = Pose2D(2.0, 1.0, 0.7)
    person = SimulatedPerson(SCRIPTS["plain"])
    for _ in range(60):
        person.step(robot)
    here, there = person.frame(robot), person.frame(robot).seen_from(ORIGIN)
    for name, place in here.joints.items():
        assert robot.to_world(place) == pytest.approx(there.joints[name])
        assert math.dist(place, here.head) < 1.2


def test_an_unknown_movement_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"no movement 'curtsy'.*handshake"):
        Act(Phase.CS, seconds=1, movement="curtsy")


# ---- a robot that runs away


@pytest.mark.parametrize("name", ORDER)
@pytest.mark.parametrize("speed", [1.19, 1.2, 3.0, 1000.0])
def test_nobody_runs_after_a_robot_for_ever(name: str, speed: float) -> None:
    def robot(t: float) -> Pose2D:
        return Pose2D(-speed * t, 0, 0)

    stations = play(SCRIPTS[name], robot)
    assert stations[-1].phase is not Phase.CS
    assert stations[-1].frame.t < 1.6 + 2 * PATIENCE


def test_patience_lasts_its_time_from_when_the_robot_was_last_gained_on() -> None:
    def robot(t: float) -> Pose2D:
        return Pose2D(-2.0 * max(0.0, t - 2), 0, 0)

    stations = play(walking(6.0), robot)
    # Nearer until 2 s; from then on ever farther.
    assert stations[-1].frame.t == pytest.approx(2 + PATIENCE, abs=0.4)


def test_patience_does_not_run_out_on_a_long_way_or_behind_a_slow_robot() -> None:
    stations = play(walking(90.0))
    assert stations[-1].frame.t == pytest.approx(89 / 1.2, abs=0.1)

    def robot(t: float) -> Pose2D:
        return Pose2D(-1.1 * t, 0, 0)

    stations = play(walking(6.0), robot)
    assert math.dist(stations[-1].position, stations[-1].robot[:2]) < 1 + 1.2 / 30 + 1e-6


# ---- gaze


def measured_gaze(frame: PersonFrame, face: Vec3) -> float:
    return float(
        head_gaze(np.array([frame.head]), np.array([frame.head_rotation]), np.array(face))[0]
    )


@given(
    gaze=st.floats(0, 1.7),
    down=st.booleans(),
    distance=st.floats(0.8, 15),
    bearing=st.floats(-math.pi, math.pi),
    turned=st.floats(-1.2, 1.2),
    height=st.floats(0.8, 2.1),
    face=st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(0.3, 1.8)),
)
def test_the_heads_direction_makes_the_stated_gaze_from_anywhere(
    gaze: float,
    down: bool,
    distance: float,
    bearing: float,
    turned: float,
    height: float,
    face: Vec3,
) -> None:
    act = Act(Phase.IA, seconds=1, gaze=gaze, looks_down=down)
    person = SimulatedPerson(Script(distance, (act,), bearing=bearing, height=height))
    frame = person.frame(Pose2D(0.05, -0.1, bearing + turned), face)
    # Beside or behind the robot's frontal plane no ray can meet it as stated.
    assume(frame.head[0] - face[0] > 0.1)
    assert measured_gaze(frame, face) == pytest.approx(gaze, abs=1e-7)


def test_looking_down_and_looking_aside_are_what_they_say() -> None:
    def direction(gaze: float, down: bool) -> Vec3:
        act = Act(Phase.IA, seconds=1, gaze=gaze, looks_down=down)
        x, y, z, w = SimulatedPerson(Script(5.0, (act,), height=1.2)).frame().head_rotation
        return 1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)

    straight = direction(0.0, False)
    assert straight == pytest.approx((-1, 0, 0), abs=1e-12)
    # Straight ahead at the face's height: the sine of the angle over tan 30 degrees (3.8).
    angle = math.asin(1.4 * math.tan(math.radians(30)))
    assert direction(1.4, True) == pytest.approx((-math.cos(angle), 0, -math.sin(angle)))
    aside = direction(1.4, False)
    assert aside[0] == pytest.approx(-math.cos(angle))
    assert abs(aside[1]) == pytest.approx(math.sin(angle))
    assert aside[2] == pytest.approx(0, abs=1e-12)


def test_a_frame_is_seen_from_the_robot() -> None:
    person = SimulatedPerson(walking(5.0, height=1.7))
    frame = person.frame(Pose2D(5.0, -2.0, math.pi / 2))
    assert frame.head == pytest.approx((2.0, 0.0, 1.7))
    assert frame.robot == Pose2D(5.0, -2.0, math.pi / 2)


# ---- mistakes


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ({}, "give one of the two"),
        ({"seconds": 1.0, "until_distance": 1.0}, "give one of the two"),
        ({"seconds": math.inf}, "give one of the two"),
        ({"seconds": 0.0}, "must be positive"),
        ({"seconds": -1.0}, "must be positive"),
        ({"until_distance": 0.0, "walking": True}, "must be positive"),
        ({"until_distance": -2.0, "walking": True}, "must be positive"),
        ({"until_distance": 2.0}, "needs a person who walks"),
        ({"seconds": 1.0, "gaze": -0.1}, "gaze lies between 0 and 1.73"),
        ({"seconds": 1.0, "gaze": 1.74}, "gaze lies between 0 and 1.73"),
        ({"seconds": 1.0, "gaze": math.nan}, "gaze lies between 0 and 1.73"),
        ({"seconds": 1.0, "smile": 5.1}, "smile between 0 and 5"),
        ({"seconds": 1.0, "smile": -1.0}, "smile between 0 and 5"),
    ],
)
def test_acts_that_cannot_be_played_are_refused(parts: dict[str, Any], reason: str) -> None:
    with pytest.raises(ParameterError, match=reason):
        Act(Phase.IA, **parts)


@pytest.mark.parametrize("name", ["start", "speed", "stop_distance", "height"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_scripts_without_a_place_are_refused(name: str, value: float) -> None:
    part: dict[str, Any] = {name: value}
    with pytest.raises(ParameterError, match=f"{name} must be positive"):
        replace(SCRIPTS["normal"], **part)


def test_scripts_without_acts_or_direction_are_refused() -> None:
    with pytest.raises(ParameterError, match="at least one act"):
        Script(3.0, ())
    for bearing in (math.nan, math.inf):
        with pytest.raises(ParameterError, match="bearing must be finite"):
            walking(bearing=bearing)


@pytest.mark.parametrize("rate", [0.0, -30.0, math.nan, math.inf])
def test_a_person_without_a_clock_is_refused(rate: float) -> None:
    with pytest.raises(ParameterError, match="frames a second must be positive"):
        SimulatedPerson(SCRIPTS["normal"], rate)


def test_an_unknown_script_answers_with_those_that_exist() -> None:
    with pytest.raises(UnknownNameError, match="valid: normal, plain, late-wave, short"):
        script("waltz")
    with pytest.raises(UnknownNameError, match="there is no simulated greeting 'waltz'"):
        open_source("simulated:waltz")


# ---- as a source


def test_the_source_plays_the_named_script() -> None:
    assert isinstance(open_source("simulated"), SimulatedSource)
    assert open_source("simulated").reacts
    for name in SCRIPTS:
        frames = list(open_source(f"simulated:{name}").frames())
        assert frames == [s.frame for s in play(SCRIPTS[name])]
    assert len(list(open_source("simulated").frames())) == len(play(SCRIPTS["normal"]))


def test_the_source_sees_the_robot_it_is_attached_to() -> None:
    source = open_source("simulated:plain")
    robot = PointRobot(Pose2D(0.5, 0.5, 0.3), face=(0.1, 0.0, 1.0))
    source.attach(robot)
    frames = source.frames()
    first = next(frames)
    assert first.robot == robot.pose
    assert robot.pose.to_world(first.head) == pytest.approx((6.0, 0.0, 1.6))
    assert measured_gaze(first, robot.face) == pytest.approx(1.0)
    robot.go_to(Pose2D(1.5, 0.5, 0.0))
    robot.update(2.0)
    second = next(frames)
    assert second.robot == robot.pose != first.robot


def test_two_runs_of_a_source_are_the_same() -> None:
    source = open_source("simulated:short")
    assert list(source.frames()) == list(source.frames())
