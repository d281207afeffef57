"""People who obey, and people who mind what the robot does: by truth that can be worked out."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kendon.errors import ParameterError, UnknownNameError
from kendon.geometry import ORIGIN, Pose2D
from kendon.phases import Phase
from kendon.robots import Appearance, PointRobot
from kendon.simulation.actor import ACCELERATION, Actor
from kendon.simulation.deeds import (
    Deed,
    Gesture,
    Look,
    Smile,
    Stand,
    Turn,
    WalkTo,
    parse_deed,
)
from kendon.simulation.live_sensor import LiveSensor, View
from kendon.simulation.reacting import REACTION, ReactingPerson
from kendon.simulation.sensors import Sensor
from kendon.simulation.temperaments import TEMPERAMENTS, Temperament, temperament
from kendon.sources import open_source

FACE = (0.0, 0.0, 1.2)
OPPOSITE = Pose2D(4.0, 0.0, math.pi)


def still(t: float, gesture: str | None = None, x: float = 0.0) -> Appearance:
    return Appearance(t, Pose2D(x, 0, 0), (x, 0.0, 1.2), (1.0, 0.0, 0.0), gesture, None, None)


def live(
    person: ReactingPerson, robot: Callable[[ReactingPerson], Appearance], longest: float = 60.0
) -> list[tuple[float, Phase | None, float]]:
    """A life: time, phase and distance to the robot at each tenth of a second."""
    found = []
    while not person.finished:
        assert person.t < longest
        seen = robot(person)
        person.live(seen)
        found.append((person.t, person.phase, math.dist(person.actor.place, seen.pose[:2])))
    return found


# ---- a body that obeys


@settings(max_examples=20, deadline=None)
@given(x=st.floats(-6, 6), y=st.floats(-6, 6), speed=st.floats(0.5, 2.0))
def test_walks_to_the_place_with_a_bodys_acceleration(x: float, y: float, speed: float) -> None:
    actor = Actor(ORIGIN, speed=speed)
    actor.act(WalkTo(x, y))
    places, speeds = [actor.place], [0.0]
    while not actor.arrived:
        actor.frames(1)
        places.append(actor.place)
        speeds.append(actor.walking_at)
        assert actor.t < 40
    assert actor.place == pytest.approx((x, y), abs=0.02)
    assert max(speeds) <= speed + 1e-9
    assert np.abs(np.diff(speeds)).max() <= ACCELERATION / actor.rate + 1e-9
    # From rest to rest over d: ramps of v / a, and no faster than the speed allows.
    assert actor.t >= math.hypot(x, y) / speed - 0.05


def test_the_joints_move_with_the_body_and_the_frames_are_a_thirtieth_apart() -> None:
    actor = Actor(OPPOSITE)
    actor.act(WalkTo(1.0, 0.0))
    frames = actor.frames(90)
    np.testing.assert_allclose(np.diff([f.t for f in frames]), 1 / 30)
    for frame in frames:
        for place in frame.joints.values():
            assert math.dist(place[:2], frame.head[:2]) < 1.0
    assert frames[0].head[0] - frames[-1].head[0] > 2.0


def test_frames_together_are_the_frames_one_by_one() -> None:
    together, single = Actor(OPPOSITE, seed=3), Actor(OPPOSITE, seed=3)
    for actor in (together, single):
        actor.act(WalkTo(2.0, 1.0))
        actor.act(Gesture("wave"))
    ours = together.frames(30)
    theirs = [frame for _ in range(30) for frame in single.frames(1)]
    for a, b in zip(ours, theirs, strict=True):
        assert a.head == pytest.approx(b.head, abs=1e-9)
        assert a.joints["r_wrist"] == pytest.approx(b.joints["r_wrist"], abs=1e-9)


@pytest.mark.parametrize(
    ("deed", "phase"),
    [
        (Look(FACE), Phase.IA),
        (WalkTo(0.5, 0.0), Phase.APP),
        (Gesture("wave"), Phase.DS),
        (Gesture("dip"), Phase.HD),
        (Gesture("handshake"), Phase.CS),
        (WalkTo(6.0, 0.0), None),
        (Look((4.0, 5.0, 1.2)), None),
    ],
)
def test_phases_are_what_the_person_really_does(deed: Deed, phase: Phase | None) -> None:
    actor = Actor(OPPOSITE, seed=2)
    actor.act(deed)
    found = set()
    for _ in range(30):
        actor.frames(1)
        found.add(actor.phase(ORIGIN))
    assert phase in found


def test_an_approach_becomes_the_final_one_at_three_metres() -> None:
    actor = Actor(Pose2D(5.0, 0.0, math.pi))
    actor.act(Look(FACE))
    actor.act(WalkTo(1.0, 0.0))
    while not actor.arrived:
        actor.frames(1)
        if actor.walking_at > 0.2:
            wanted = Phase.FA if actor.x < 3.0 else Phase.APP
            assert actor.phase(ORIGIN) is wanted


def test_turning_looking_and_smiling_get_there() -> None:
    actor = Actor(ORIGIN)
    for deed in (Turn(1.2), Smile(3.0)):
        actor.act(deed)
    frames = actor.frames(60)
    assert actor.heading == pytest.approx(1.2, abs=0.01)
    assert frames[-1].smile == pytest.approx(3.0, abs=0.01)
    actor.act(WalkTo(5.0, 0.0))
    actor.frames(30)
    actor.act(Stand())
    actor.frames(30)
    assert actor.walking_at == 0.0


@pytest.mark.parametrize(
    ("text", "deed"),
    [
        ("walk 1 2", WalkTo(1.0, 2.0)),
        ("turn 90", Turn(math.pi / 2)),
        ("look", Look()),
        ("look 0 0 1.2", Look(FACE)),
        ("smile 2", Smile(2.0)),
        ("stand", Stand()),
        *((kind, Gesture(kind)) for kind in ("wave", "toss", "nod", "dip", "bow", "handshake")),
    ],
)
def test_deeds_in_words(text: str, deed: Deed) -> None:
    assert repr(parse_deed(text)) == repr(deed)


@pytest.mark.parametrize("text", ["walk", "walk 1", "walk a b", "smile 9", "wave 3", "walk nan 1"])
def test_deeds_that_do_not_fit_are_refused(text: str) -> None:
    with pytest.raises(ParameterError):
        parse_deed(text)


def test_unknown_deeds_list_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="handshake"):
        parse_deed("dance")


# ---- people who react


def greeting(**parts: object) -> Temperament:
    """Somebody who sights for a moment, walks up and holds out a hand."""
    return Temperament("test", "", **{"salutes": 0.0, "patience": 2.0, **parts})  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(5))
def test_a_close_salutation_that_is_ignored_is_given_up_within_the_patience(seed: int) -> None:
    person = ReactingPerson(greeting(), OPPOSITE, seed=seed)
    life = live(person, lambda p: still(p.t))
    assert person.gave_up == "their close salutation was not answered"
    begun = next(t for t, phase, _ in life if phase is Phase.CS)
    ended = next(t for t, phase, _ in life if t > begun and phase is None)
    assert ended - begun <= 2.0 + 1.0  # the patience, and the rest of the hand's rise
    assert life[-1][2] > 3.0  # they left


@pytest.mark.parametrize("seed", range(5))
def test_a_hand_that_is_offered_is_taken_and_shaken(seed: int) -> None:
    person = ReactingPerson(greeting(), OPPOSITE, seed=seed)

    def robot(p: ReactingPerson) -> Appearance:
        near = p.actor.x < 1.6
        return still(p.t, "handshake" if near else None)

    live(person, robot)
    assert not person.gave_up
    assert Phase.CS in person.answered
    assert {m.kind for m in person.made} == {"handshake"}


def test_who_salutes_with_the_head_looks_at_the_robot_first() -> None:
    """Within 15 degrees: the look wanders by some."""
    heads = 0
    for seed in range(40):
        person = ReactingPerson(greeting(salutes=1.0, waits=True), OPPOSITE, seed=seed)
        before = 0
        while not person.finished and person.t < 8.0:
            frame = person.actor.frame()
            person.live(still(person.t))
            if len(person.made) > before:
                before = len(person.made)
                if person.made[-1].kind in ("nod", "toss"):
                    heads += 1
                    nose = Rotation.from_quat(frame.head_rotation).apply([1.0, 0.0, 0.0])
                    way = np.array(FACE) - frame.head
                    off = math.acos(nose @ way / np.linalg.norm(way))
                    assert off < math.radians(15)
    assert heads > 3


def test_a_salutation_is_waited_for_and_the_answer_is_seen_a_little_late() -> None:
    shy = greeting(salutes=1.0, waits=True, dips=0.0)
    person = next(
        p
        for p in (ReactingPerson(shy, Pose2D(6, 0, math.pi), seed=s) for s in range(40))
        if (live(p, lambda q: still(q.t)), p.gave_up)[1] == "their salutation was not answered"
    )
    seed = next(
        s
        for s in range(40)
        if ReactingPerson(shy, Pose2D(6, 0, math.pi), seed=s).actor.body == person.actor.body
    )
    again = ReactingPerson(shy, Pose2D(6, 0, math.pi), seed=seed)
    waved = math.nan

    def robot(p: ReactingPerson) -> Appearance:
        nonlocal waved
        if p.phase is Phase.DS and waved != waved:
            waved = p.t
        return still(p.t, "wave" if p.t >= waved else None)

    live(again, robot)
    assert again.answered[Phase.DS] - waved >= REACTION - 0.1 - 1e-6
    assert again.gave_up != "their salutation was not answered"


@pytest.mark.parametrize("comfort", [0.8, 1.0])
def test_a_robot_that_comes_too_close_is_backed_away_from(comfort: float) -> None:
    person = ReactingPerson(greeting(comfort=comfort, sighting=8.0), OPPOSITE, seed=1)
    x, life = 3.0, []
    while person.t < 8.0:
        x = min(x + 0.03, 3.4)  # 0.3 m/s up to 0.6 m before the person, then it stands
        person.live(still(person.t, x=x))
        life.append(person.actor.x - x)
    assert min(life) > comfort - 0.15  # who stayed would have had it at 0.6 m
    assert life[-1] >= comfort
    assert person.step_backs >= 1


def test_a_robot_that_comes_too_fast_frightens_only_those_it_frightens() -> None:
    for fright, backs in ((0.6, True), (math.inf, False)):
        person = ReactingPerson(greeting(fright=fright, sighting=3.0), OPPOSITE, seed=1)
        for _ in range(25):
            x = min(person.t * 1.0, 2.5)  # 1 m/s
            person.live(still(person.t, x=x))
        assert (person.step_backs > 0) is backs


def test_a_robot_that_cannot_be_reached_is_given_up() -> None:
    person = ReactingPerson(greeting(), OPPOSITE, seed=1)
    live(person, lambda p: still(p.t, x=p.actor.x - 3.0))
    assert person.gave_up == "they could not reach the robot"


def test_whoever_changes_their_mind_leaves_half_way() -> None:
    person = ReactingPerson(greeting(turns_at=0.5), Pose2D(6, 0, math.pi), seed=1)
    life = live(person, lambda p: still(p.t))
    assert person.gave_up == "they changed their mind"
    assert min(d for *_, d in life) == pytest.approx(6 - 0.5 * 4.9, abs=0.5)
    assert life[-1][1] is None


@pytest.mark.parametrize("past", [0.8, 1.5, 2.5])
def test_whoever_ignores_the_robot_passes_at_their_distance_and_greets_nobody(past: float) -> None:
    person = ReactingPerson(temperament("ignoring"), Pose2D(6, 0, math.pi), past=past, seed=4)
    life = live(person, lambda p: still(p.t))
    assert {phase for _, phase, _ in life} == {None}
    assert min(d for *_, d in life) == pytest.approx(past, abs=0.1)


@pytest.mark.parametrize("name", TEMPERAMENTS)
def test_every_life_comes_to_an_end_and_repeats_itself(name: str) -> None:
    lives = [
        live(ReactingPerson(temperament(name), OPPOSITE, seed=9), lambda p: still(p.t))
        for _ in range(2)
    ]
    assert lives[0] == lives[1]


def test_unknown_temperaments_list_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="eager"):
        temperament("grumpy")
    with pytest.raises(UnknownNameError, match="late-wave"):
        open_source("simulated:grumpy")


# ---- what reaches the person, and the robot


def test_a_robots_appearance_is_what_it_does() -> None:
    robot = PointRobot(Pose2D(1.0, 2.0, math.pi / 2))
    robot.gesture("wave")
    robot.say("Good morning")
    robot.look_at((1.0, 5.0, 1.2))
    robot.update(0.5)
    seen = robot.appearance
    assert (seen.gesture, seen.speech, seen.t) == ("wave", "Good morning", 0.5)
    assert seen.face == pytest.approx((1.0, 2.0, 1.2))
    assert seen.looks_at((1.0, 5.0, 1.2)) == pytest.approx(0, abs=0.02)
    assert seen.looks_at((1.0, -5.0, 1.2)) == pytest.approx(math.pi, abs=0.02)


@pytest.mark.parametrize(
    ("aside", "seen"), [(0.0, True), (0.65, True), (0.75, False), (3.0, False)]
)
def test_only_those_in_the_view_of_the_moving_head_are_seen(aside: float, seen: bool) -> None:
    sensor = LiveSensor(Sensor(), View(width=1.4, height=1.0))
    actor = Actor(Pose2D(3.0, 0.0, math.pi))
    frame = actor.frames(1)[0]
    gaze = (math.cos(aside), math.sin(aside), 0.0)
    robot = Appearance(0.0, ORIGIN, FACE, gaze, None, None, None)
    assert sensor.see(frame, robot).seen is seen


def test_the_noise_of_a_live_sensor_is_that_of_its_model() -> None:
    noisy = Sensor(range_noise=0.05, dropped=0.2, joint_noise=0.03, arm_loss=0.1)
    sensor = LiveSensor(noisy, seed=1)
    frames = [sensor.see(f, still(f.t)) for f in Actor(Pose2D(4, 0, math.pi)).frames(6000)]
    found = [f for f in frames if f.seen]
    assert 1 - len(found) / len(frames) == pytest.approx(0.2, abs=0.02)
    assert np.std([f.head[0] for f in found]) / 4 == pytest.approx(0.05, rel=0.1)
    hidden = np.mean(["l_wrist" not in f.joints for f in found])
    assert hidden == pytest.approx(0.1, abs=0.06)


def test_a_view_is_an_angle() -> None:
    with pytest.raises(ParameterError, match="field of view"):
        View(width=0.0)
