"""The user's person: moved as people move, read as people are read."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from viewer.browser import encounters

from kendon.errors import ParameterError, UnknownNameError
from kendon.geometry import ORIGIN, Pose2D, quaternion_yaw, wrap_angle
from kendon.phases import Phase
from kendon.robots import PointRobot
from kendon.simulation.actor import ACCELERATION
from kendon.simulation.scripts import WALKING_SPEED
from kendon.viewer.browser.player import ACTS, NEAREST, Player

_FLOOR = st.floats(-8, 8)


@given(goals=st.lists(st.tuples(_FLOOR, _FLOOR), min_size=1, max_size=3), seed=st.integers(0, 99))
@settings(max_examples=25, deadline=None)
def test_the_person_walks_with_a_body_s_inertia(
    goals: list[tuple[float, float]], seed: int
) -> None:
    player = Player(seed=seed)
    for goal in goals:
        player.walk_to(*goal)
        for _ in range(90):
            before, place = player.actor.velocity, player.actor.place
            player.step()
            velocity = player.actor.velocity
            assert math.dist(velocity, before) <= ACCELERATION / player.actor.rate + 1e-9
            assert math.hypot(*velocity) <= WALKING_SPEED + 1e-9
            way = np.subtract(player.actor.place, place)
            assert np.allclose(way, np.divide(velocity, player.actor.rate))


@given(x=_FLOOR, y=_FLOOR)
@settings(max_examples=20, deadline=None)
def test_the_person_gets_where_they_are_sent_unless_the_robot_stands_there(
    x: float, y: float
) -> None:
    player = Player(rate=15.0)
    player.walk_to(x, y)
    nearest = math.inf
    for _ in range(15 * 25):
        player.step()
        nearest = min(nearest, math.hypot(*player.actor.place))
    assert nearest > NEAREST - 0.15
    if math.hypot(x, y) >= NEAREST:
        assert math.dist(player.actor.place, (x, y)) < 0.05
    else:
        assert math.hypot(*player.actor.place) == pytest.approx(NEAREST, abs=0.05)


def test_a_place_beyond_the_floor_is_taken_for_its_edge() -> None:
    player = Player()
    player.walk_to(1e6, 0.0)
    assert player.goal == (12.0, 0.0)


def test_walking_up_follows_a_robot_that_moves() -> None:
    player = Player()
    player.walk_up(1.1)
    for i in range(20 * 30):
        player.step(Pose2D(-0.005 * i, 0.0, 0.0))
    robot = (-0.005 * 599, 0.0)
    assert math.dist(player.actor.place, robot) == pytest.approx(1.1, abs=0.15)


def test_a_stop_brakes_within_the_legs_power() -> None:
    player = Player()
    player.walk_to(-6.0, 1.5)
    for _ in range(60):
        player.step()
    place = player.actor.place
    player.stop()
    for _ in range(60):
        player.step()
    assert player.actor.walking_at < 0.02
    assert math.dist(place, player.actor.place) == pytest.approx(
        1.2**2 / (2 * ACCELERATION), abs=0.2
    )


def test_the_head_turns_where_it_is_told_but_not_off_the_body() -> None:
    player = Player((3.0, 0.0))
    for where, yaw in (("robot", math.pi), ("away", math.pi + math.radians(65))):
        player.look(where)
        assert mean_look(player, yaw) == pytest.approx(0.0, abs=0.02)
    player.look("robot")
    player.turn("away")
    turned = abs(mean_look(player, 0.0))
    assert turned == pytest.approx(math.radians(75), abs=0.05)


def mean_look(player: Player, yaw: float) -> float:
    """Where a head that is never quite still points on average [rad], from a heading."""
    looks = []
    for step in range(30 * 20):
        player.step()
        if step >= 4 * 30:  # it takes its time to turn there
            looks.append(wrap_angle(quaternion_yaw(player.frame().head_rotation) - yaw))
    return sum(looks) / len(looks)


def test_told_gestures_are_given_only_while_they_last() -> None:
    player = Player((4.0, 0.0))
    player.act("wave")
    assert player.frame().dsal == 1.0
    for _ in range(30 * 3):
        player.step()
    assert player.frame().dsal == 0.0
    player.keys = False
    assert math.isnan(player.frame().dsal)


def test_a_wave_at_arm_s_length_is_a_close_salutation() -> None:
    player = Player((1.0, 0.0))
    player.act("wave", ORIGIN)
    assert (player.frame().dsal, player.frame().csal) == (0.0, 1.0)


def test_every_act_can_be_performed_and_ends() -> None:
    for name, seconds in ACTS.items():
        player = Player()
        player.act(name)
        assert player.doing == name
        for _ in range(round(30 * (seconds + 2))):
            player.step()
        assert player.doing == "", name


def test_what_cannot_be_done_is_refused_by_name() -> None:
    player = Player()
    with pytest.raises(UnknownNameError, match="valid: wave"):
        player.act("jump")
    with pytest.raises(UnknownNameError, match="valid: robot"):
        player.look("up")
    with pytest.raises(UnknownNameError, match="valid: robot, away"):
        player.turn("left")
    with pytest.raises(ParameterError, match="finite"):
        player.walk_to(math.nan, 0.0)
    with pytest.raises(ParameterError, match="positive"):
        player.walk_up(-1.0)


@pytest.mark.parametrize("keys", [True, False], ids=["told", "read off the body"])
def test_a_wave_is_answered_with_a_wave(keys: bool) -> None:
    session = encounters.played(keys=keys)
    assert session.player is not None
    encounters.pass_time(session, 2.0)
    session.player.act("wave")
    seen, waved = set(), False
    for _ in range(30):
        encounters.pass_time(session, 0.1)
        seen.add(session.stage.snapshots[-1].phase)
        robot = session.stage.robot
        assert isinstance(robot, PointRobot)
        waved = waved or robot.performing == "wave"
    assert Phase.DS in seen
    assert waved


def test_a_whole_greeting_ends_in_a_handshake() -> None:
    session = encounters.played()
    player = session.player
    assert player is not None
    encounters.pass_time(session, 1.5)
    player.act("wave")
    encounters.pass_time(session, 2.0)
    player.walk_up(1.1)
    player.look("down")
    encounters.pass_time(session, 2.0)
    player.look("robot")
    player.smile(True)
    encounters.pass_time(session, 3.0)
    player.act("handshake", session.stage.robot.pose)
    encounters.pass_time(session, 2.5)
    read = [s.phase for s in session.stage.snapshots if s.phase]
    order = [p for i, p in enumerate(read) if i == 0 or p is not read[i - 1]]
    assert next(p for p in order if p in (Phase.DS, Phase.APP, Phase.CS)) is Phase.DS
    assert read[-1] is Phase.CS
    assert any(s.saying for s in session.stage.snapshots)
