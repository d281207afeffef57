"""Algorithm 2 against a service of Gazebo's type."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros.ros1_world import Master

from kendon.errors import KendonError, ParameterError, RobotError
from kendon.geometry import Pose2D
from kendon.ros.ros1 import gazebo
from kendon.ros.ros1.environment import messages, ros_module
from kendon.ros.ros1.gazebo import GazeboPerson, stations

coordinates = st.floats(-20, 20)


@given(coordinates, coordinates, coordinates, coordinates, st.floats(0.3, 2.0))
def test_a_walk_is_even_and_ends_at_its_goal(
    x0: float, y0: float, x1: float, y1: float, speed: float
) -> None:
    start, goal = Pose2D(x0, y0, 0.0), Pose2D(x1, y1, 0.0)
    places = stations(start, goal, speed)
    assert (places[0].x, places[0].y) == (x0, y0)
    assert places[-1].distance_to(goal) < 1e-9
    way = start.distance_to(goal)
    count = len(places) - 1
    assert count == max(1, round(10 * way / speed))  # ten stations a second
    for a, b in zip(places, places[1:], strict=False):
        assert a.distance_to(b) == pytest.approx(way / count, abs=1e-9)
    if way > 1e-6:
        assert math.cos(places[0].yaw) * way == pytest.approx(x1 - x0, abs=1e-6)


def test_a_walk_has_a_speed() -> None:
    with pytest.raises(ParameterError, match="positive number of m/s, not 0"):
        stations(Pose2D(0, 0, 0), Pose2D(1, 0, 0), 0.0)


@pytest.fixture
def told(master: Master) -> Iterator[list[Any]]:
    """A service like Gazebo's, which knows one model; and what it was asked."""
    del master
    asked: list[Any] = []
    types = messages("gazebo_msgs")

    def move(request: Any) -> Any:
        asked.append(request.model_state)
        known = request.model_state.model_name == "pessoa1"
        return types.SetModelStateResponse(known, "" if known else "model does not exist")

    service = ros_module("rospy").Service("/gazebo/set_model_state", types.SetModelState, move)
    yield asked
    service.shutdown("the test ends")


def test_the_person_is_put_at_each_station(told: list[Any]) -> None:
    start, goal = Pose2D(5.5, 1.0, 0.0), Pose2D(4.9, 1.0, 0.0)
    walked = list(GazeboPerson().walk(start, goal, 1.2))
    assert walked == stations(start, goal, 1.2)
    assert [(s.pose.position.x, s.pose.position.y) for s in told] == [(p.x, p.y) for p in walked]
    assert {s.reference_frame for s in told} == {"world"}
    assert abs(told[0].pose.orientation.z) == pytest.approx(1.0)  # they look along -x


def test_what_gazebo_says_is_quoted(told: list[Any]) -> None:
    with pytest.raises(RobotError, match="does not move 'nobody': model does not exist"):
        GazeboPerson("nobody").put(Pose2D(0, 0, 0))


def test_without_gazebo_it_says_how_to_start_it(
    master: Master, monkeypatch: pytest.MonkeyPatch
) -> None:
    del master
    monkeypatch.setattr(gazebo, "_ANSWERS", 0.2)
    with pytest.raises(KendonError, match=r"nobody offers the service /no/such.*roslaunch"):
        GazeboPerson(service="/no/such")
