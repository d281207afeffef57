"""PointRobot: the contract, and its head, arms, voice, face and arguments."""

from __future__ import annotations

import math
from typing import Any

import pytest
from robots.robot_contract import RobotContract, run_until_ended

from kendon.errors import ParameterError, UnknownNameError
from kendon.geometry import Pose2D
from kendon.robots.base import Appearance, CommandStatus, Robot
from kendon.robots.drive import BaseLimits
from kendon.robots.head import HeadLimits
from kendon.robots.point import EXPRESSION_SECONDS, GESTURE_SECONDS, SPEECH_RATE, PointRobot


class TestPointRobotContract(RobotContract):
    def make(self) -> Robot:
        return PointRobot()


class TestPointRobotContractElsewhere(RobotContract):
    """Nothing may depend on starting at the origin, alone and with one's face over the axle."""

    def make(self) -> Robot:
        robot = PointRobot(Pose2D(-3.0, 2.0, 2.5), face=(0.1, 0.0, 1.1), leash=2.0)
        robot.person = (-1.0, -6.0, 1.6)
        return robot


class TestHead:
    def test_the_face_points_at_the_point(self) -> None:
        robot = PointRobot(Pose2D(1.0, 2.0, 0.7), face=(0.1, 0.0, 1.2))
        point = (2.0, 4.0, 1.7)
        look = robot.look_at(point)
        run_until_ended(robot, look)
        face = robot.pose.to_world(robot.face)
        way = tuple(p - f for p, f in zip(point, face, strict=True))
        cosine = sum(a * b for a, b in zip(way, robot.gaze_direction, strict=True)) / math.hypot(
            *way
        )
        assert cosine > math.cos(2 * HeadLimits().tolerance)
        assert math.hypot(*robot.gaze_direction) == pytest.approx(1.0)
        assert look.sent["pan"] == pytest.approx(robot.pan, abs=HeadLimits().tolerance)
        assert look.sent["tilt"] == pytest.approx(robot.tilt, abs=HeadLimits().tolerance)

    def test_it_turns_at_its_rate(self) -> None:
        robot = PointRobot(head=HeadLimits(rate=0.5))
        look = robot.look_at((1.0, 1.0, 1.2))  # 45 degrees to the left: pi / 4 / 0.5 = 1.57 s
        robot.update(1.0)
        assert robot.pan == pytest.approx(0.5)
        robot.update(1.5)
        assert look.running
        robot.update(1.58)
        assert look.status is CommandStatus.SUCCEEDED
        assert robot.pan == pytest.approx(math.pi / 4)

    def test_up_is_positive(self) -> None:
        robot = PointRobot()
        run_until_ended(robot, robot.look_at((1.0, 0.0, 2.0)))
        assert robot.tilt > 0
        assert robot.gaze_direction[2] > 0

    def test_a_cancelled_look_leaves_the_head_where_it_is(self) -> None:
        robot = PointRobot()
        look = robot.look_at((0.0, 1.0, 1.2))
        robot.update(0.2)
        look.cancel()
        robot.update(1.0)
        assert robot.pan == pytest.approx(0.2 * HeadLimits().rate)

    def test_turns_of_the_base_are_made_up_for_only_while_it_looks(self) -> None:
        robot = PointRobot(head=HeadLimits(rate=1.5))
        point = (3.0, 1.0, 1.2)
        turn, look = robot.turn_to(-1.5), robot.look_at(point)
        while look.running:
            robot.update(robot.time + 0.02)
        assert turn.running
        pan, tilt, _ = robot._head.angles_to(point, robot.pose)
        assert robot.pan == pytest.approx(pan, abs=HeadLimits().tolerance)
        kept = robot.pan
        run_until_ended(robot, turn)
        assert robot.pan == kept
        assert robot.tilt == pytest.approx(tilt, abs=HeadLimits().tolerance)

    def test_beyond_the_joints_it_goes_to_the_limit_and_says_so(self) -> None:
        robot = PointRobot()
        look = robot.look_at((-2.0, 0.1, 1.2))
        assert look.sent["pan"] == HeadLimits().pan[1]
        run_until_ended(robot, look)
        assert look.status is CommandStatus.SUCCEEDED
        assert look.reason == "the point lies beyond the head's joints"
        assert robot.pan == pytest.approx(HeadLimits().pan[1])

    def test_it_waits_at_the_limit_for_a_base_that_turns(self) -> None:
        robot = PointRobot()
        robot.turn_to(3.0)
        look = robot.look_at((-2.0, 0.0, 1.2))
        run_until_ended(robot, look)
        assert (look.status, look.reason) == (CommandStatus.SUCCEEDED, "")
        assert abs(robot.pan) <= HeadLimits().pan[1]

    def test_it_cannot_look_into_its_own_face(self) -> None:
        look = PointRobot().look_at((0.0, 0.0, 1.2))
        assert look.status is CommandStatus.FAILED
        assert "own face" in look.reason


class TestArmsVoiceAndFace:
    @pytest.mark.parametrize("name", PointRobot.gestures)
    def test_a_gesture_takes_its_time(self, name: str) -> None:
        robot = PointRobot()
        gesture = robot.gesture(name)
        seconds = GESTURE_SECONDS[name]
        robot.update(seconds - 0.01)
        assert robot.performing == name
        robot.update(seconds)
        assert gesture.status is CommandStatus.SUCCEEDED
        assert gesture.ended == seconds
        assert robot.performing is None

    def test_durations_can_be_given(self) -> None:
        robot = PointRobot(gesture_seconds={"wave": 0.25})
        gesture = robot.gesture("wave")
        robot.update(0.25)
        assert not gesture.running

    def test_speech_takes_its_length(self) -> None:
        robot = PointRobot()
        words = robot.say("Muito prazer", "pt")
        robot.update(12 / SPEECH_RATE - 0.01)
        assert robot.saying == "Muito prazer"
        robot.update(12 / SPEECH_RATE)
        assert words.status is CommandStatus.SUCCEEDED
        assert robot.saying is None

    def test_an_expression_comes_up_and_stays(self) -> None:
        robot = PointRobot()
        assert robot.expression == ("neutral", 1.0)
        smile = robot.express("smile", 0.8)
        assert robot.expression == ("smile", 0.0)
        robot.update(EXPRESSION_SECONDS / 2)
        assert robot.expression[0] == "smile"
        assert robot.expression[1] == pytest.approx(0.4)
        robot.update(10.0)
        assert robot.expression[0] == "smile"
        assert robot.expression[1] == pytest.approx(0.8)
        assert smile.status is CommandStatus.SUCCEEDED
        robot.express("smile", 0.2)
        assert robot.expression[0] == "smile"
        assert robot.expression[1] == pytest.approx(0.8)

    def test_ends_are_met_by_sums_of_time_steps(self) -> None:
        robot = PointRobot()
        gesture = robot.gesture("wave")
        for _ in range(30):
            robot.update(robot.time + 0.1)  # ten times 0.1 is less than 1 in floating point
        assert not gesture.running


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"start": Pose2D(0.0, math.nan, 0.0)}, "start needs 3 finite numbers"),
        ({"face": (0.0, 0.0, math.inf)}, "face needs 3 finite numbers"),
        ({"face": (0.0, 1.2)}, "face needs 3 finite numbers"),
        ({"keep_distance": -0.1}, "keep_distance is a finite number of m, at least 0, not -0.1"),
        ({"keep_distance": math.nan}, "keep_distance .* not nan"),
        ({"leash": -1.0}, "leash .* at least 0, not -1.0"),
        ({"position_tolerance": 0.0}, "position_tolerance .* more than 0, not 0.0"),
        ({"yaw_tolerance": math.inf}, "yaw_tolerance .* not inf"),
        ({"speech_rate": 0.0}, "speech_rate .* characters/s, more than 0"),
        ({"gesture_seconds": {"wave": -1.0}}, r"gesture_seconds\['wave'\] .* at least 0"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        PointRobot(**arguments)


def test_limits_out_of_range_are_refused() -> None:
    with pytest.raises(ParameterError, match="speed is a positive, finite number, not 0"):
        BaseLimits(speed=0.0)
    with pytest.raises(ParameterError, match=r"turn_acceleration .* not nan"):
        BaseLimits(turn_acceleration=math.nan)
    with pytest.raises(ParameterError, match=r"pan range .* not from 0.5 to 1.0"):
        HeadLimits(pan=(0.5, 1.0))
    with pytest.raises(ParameterError, match=r"rate .* not -1"):
        HeadLimits(rate=-1.0)
    with pytest.raises(UnknownNameError, match="gesture 'bow'"):
        PointRobot(gesture_seconds={"bow": 1.0})


def test_points_out_of_this_world_are_refused_by_the_robot() -> None:
    robot = PointRobot()
    for command in (robot.go_to(Pose2D(1e200, 0.0, 0.0)), robot.look_at((0.0, 1e308, 0.0))):
        assert command.status is CommandStatus.FAILED
        assert "farther than 1000 m away" in command.reason


def test_a_long_wait_costs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = PointRobot()
    steps: list[float] = []
    one_step = robot._base._step

    def step(h: float) -> bool:
        steps.append(h)
        return one_step(h)

    drive = robot.go_to(Pose2D(2.0, 1.0, 0.0))
    monkeypatch.setattr(robot._base, "_step", step)
    robot.update(1.7e9)  # a robot whose clock is the time of day
    assert len(steps) < 1000  # it drove there and then stood, without a step for all that time
    assert drive.status is CommandStatus.SUCCEEDED


def test_the_angle_to_a_place_that_is_unknown_is_unknown() -> None:
    seen = Appearance(0.0, Pose2D(0, 0, 0), (0, 0, 1.2), (1, 0, 0), None, None, None)
    assert seen.looks_at((-2, 0, 1.2)) == pytest.approx(math.pi)
    assert math.isnan(seen.looks_at((math.nan, 0, 1.2)))
