"""MujocoRobot: the contract, and its body against closed forms, limits and PointRobot."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robots.robot_contract import RobotContract, run_until_ended
from scipy.signal import find_peaks

from kendon.errors import ParameterError
from kendon.geometry import ORIGIN, Pose2D, Vec3, wrap_angle
from kendon.person import FloatArray
from kendon.robots.base import CommandStatus, Robot
from kendon.robots.mujoco import MujocoRobot, read_description
from kendon.robots.mujoco.body import CYCLE
from kendon.robots.point import EXPRESSION_SECONDS, PointRobot

SIMPLE = Path(__file__).resolve().parents[2] / "examples" / "robot" / "pan_tilt.toml"
EYES = ("l_eye", "r_eye")
near = st.floats(-2.5, 2.5)
angle = st.floats(-math.pi, math.pi)
poses = st.builds(Pose2D, near, near, angle)
heights = st.floats(0.0, 2.2)


class SimpleRobot(MujocoRobot):
    """The example: one arm, and a tilt joint that looks down in its positive direction."""

    def __init__(self, start: Pose2D = ORIGIN, *, patience: float = 5.0) -> None:
        super().__init__(start, description=read_description(SIMPLE), patience=patience)


class TestMujocoRobotContract(RobotContract):
    def make(self) -> Robot:
        return MujocoRobot()


class TestMujocoRobotContractElsewhere(RobotContract):
    """Nothing may depend on starting at the origin and alone."""

    def make(self) -> Robot:
        robot = MujocoRobot(Pose2D(-3.0, 2.0, 2.5), leash=2.0)
        robot.person = (-1.0, -6.0, 1.6)
        return robot


class TestContractOfARobotFromAFile(RobotContract):
    def make(self) -> Robot:
        return SimpleRobot()


def fine(robot: MujocoRobot) -> None:
    """No state may be wrong, and no joint or wheel beyond what the robot can do."""
    body, limits = robot.body, robot.description.limits
    assert np.isfinite(body.data.qpos).all()
    assert not body.data.warning.number.any()
    assert (body.angles >= body.low - 0.01).all()
    assert (body.angles <= body.high + 0.01).all()
    assert (np.abs(body.velocities) <= 1.01 * body.speeds).all()
    speed, turn_rate = body.base_speeds
    assert abs(speed) <= 1.02 * limits.speed
    assert abs(turn_rate) <= 1.02 * limits.turn_rate
    sideways = body.data.qvel[:2] @ [-math.sin(robot.pose.yaw), math.cos(robot.pose.yaw)]
    assert abs(sideways) < 0.02  # wheels do not slide


def hand_over_time(robot: MujocoRobot, site: str, seconds: float) -> FloatArray:
    """A site in the base frame over time, a row a control cycle, (T, 3) [m]."""
    places = []
    for _ in range(round(seconds / CYCLE)):
        robot.update(robot.time + CYCLE)
        fine(robot)
        places.append(robot.pose.to_local(tuple(robot.body.sight(site)[0].tolist())))
    return np.array(places)


def off(robot: MujocoRobot, sight: str, point: Vec3) -> float:
    """By how much a line of sight misses a point [rad]."""
    place, turn = robot.body.sight(sight)
    way = np.array(point) - place
    return math.acos(min(1.0, float(turn[:, 0] @ way / np.linalg.norm(way))))


class TestHead:
    @pytest.mark.parametrize("make", [MujocoRobot, SimpleRobot])
    @settings(max_examples=25, deadline=None)
    @given(start=poses, away=st.floats(0.6, 5.0), bearing=st.floats(-1.4, 1.4), height=heights)
    def test_the_line_of_sight_passes_through_the_point(
        self, make: type[MujocoRobot], start: Pose2D, away: float, bearing: float, height: float
    ) -> None:
        """By kinematics alone: the angles of the closed form, put into the joints."""
        robot = make(start)
        point = start.to_world((away * math.cos(bearing), away * math.sin(bearing), height))
        body = robot.body
        pan, tilt = body.head.angles(body.data, point)
        angles = body.angles.copy()
        angles[[body.pan, body.tilt]] = pan, tilt
        body.data.qpos[body.model.jnt_qposadr[body.joint_ids]] = angles
        body.settle()
        place, turn = body.sight(robot.description.head.face)
        way = np.array(point) - place
        assert np.linalg.norm(np.cross(turn[:, 0], way)) < 1e-6
        assert turn[:, 0] @ way > 0

    @pytest.mark.parametrize("make", [MujocoRobot, SimpleRobot])
    @pytest.mark.parametrize("point", [(2.0, 1.0, 1.7), (1.0, -0.9, 0.8), (1.2, 0.0, 1.6)])
    def test_it_looks_there_also_while_the_base_turns(
        self, make: type[MujocoRobot], point: Vec3
    ) -> None:
        robot = make(Pose2D(0.1, 0.2, -0.3))
        robot.turn_to(0.3)
        look = robot.look_at(point)
        run_until_ended(robot, look)
        assert (look.status, look.reason) == (CommandStatus.SUCCEEDED, "")
        assert off(robot, robot.description.head.face, point) < 0.03

    def test_left_and_up_are_positive(self) -> None:
        for robot in (MujocoRobot(), SimpleRobot()):
            run_until_ended(robot, robot.look_at((2.0, 1.0, 2.0)))
            assert robot.pan > 0.3
            assert robot.tilt > 0.1
            assert robot.gaze_direction[1] > 0
            assert robot.gaze_direction[2] > 0

    def test_a_waist_that_leans_is_made_up_for(self) -> None:
        robot = MujocoRobot()
        point = (1.0, 0.0, 1.6)
        robot.look_at(point)
        robot.gesture("handshake")
        robot.update(2.0)
        look = robot.look_at(point)
        robot.update(2.4)
        assert look.status is CommandStatus.SUCCEEDED
        assert robot.body.angles[robot.body.index("test", "waist_joint")] > 0.2
        assert off(robot, "face", point) < 0.02

    def test_the_eyes_are_there_first_and_meet_in_the_point(self) -> None:
        robot = MujocoRobot()
        point = (0.9, 0.7, 1.2)
        look = robot.look_at(point)
        robot.update(0.3)
        assert look.running
        assert max(off(robot, eye, point) for eye in EYES) < 0.75 * off(robot, "face", point)
        run_until_ended(robot, look)
        robot.look_at(point)
        robot.update(robot.time + 0.5)
        assert max(off(robot, eye, point) for eye in EYES) < 0.02

    def test_beyond_the_joints_it_goes_to_the_limit_and_says_so(self) -> None:
        robot = MujocoRobot()
        look = robot.look_at((-2.0, 0.1, 1.0))
        assert look.sent["pan"] == pytest.approx(2.03)
        run_until_ended(robot, look)
        assert look.status is CommandStatus.SUCCEEDED
        assert look.reason == "the point lies beyond the head's joints"
        assert robot.pan == pytest.approx(2.03, abs=0.02)

    def test_a_cancelled_look_leaves_the_head_where_it_is(self) -> None:
        robot = MujocoRobot()
        look = robot.look_at((0.0, 2.0, 1.0))
        robot.update(0.4)
        look.cancel()
        robot.update(0.8)
        rest = robot.pan
        assert 0.2 < rest < 1.2
        robot.update(2.0)
        assert robot.pan == pytest.approx(rest, abs=1e-3)

    def test_it_cannot_look_into_its_own_face(self) -> None:
        robot = MujocoRobot()
        look = robot.look_at(robot.face)
        assert look.status is CommandStatus.FAILED
        assert "own face" in look.reason


class TestGestures:
    @pytest.mark.parametrize("name", MujocoRobot().gestures)
    def test_each_stays_within_the_limits_and_ends_at_rest(self, name: str) -> None:
        robot = MujocoRobot()
        gesture = robot.gesture(name)
        while gesture.running:
            robot.update(robot.time + CYCLE)
            fine(robot)
        assert gesture.status is CommandStatus.SUCCEEDED
        robot.update(robot.time + 1.0)
        assert robot.body.angles == pytest.approx(robot.body.rest, abs=0.01)

    def test_the_arm_follows_the_keyframes(self) -> None:
        """At a keyframe that is held, the joints are where the file says."""
        robot = MujocoRobot()
        robot.gesture("stretch")
        robot.update(2.2)
        for frame in robot.description.gestures["stretch"][:1]:
            points = robot.body.set_points("test", frame.joints)
            for joint, point in points.items():
                assert robot.body.angles[joint] == pytest.approx(point, abs=0.01)

    def test_a_wave_swings_a_raised_hand(self) -> None:
        robot = MujocoRobot()
        robot.gesture("wave")
        hand = hand_over_time(robot, "r_hand", 4.5)
        raised = hand[hand[:, 2] > robot.body.sight("face")[0][2] - 0.1]
        assert len(raised) > 1.5 / CYCLE
        swings, _ = find_peaks(raised[:, 1], prominence=0.08)
        assert len(swings) >= 2
        assert hand[-1] == pytest.approx(hand[0], abs=0.01)

    def test_a_handshake_has_three_shakes_in_front_of_the_robot(self) -> None:
        robot = MujocoRobot()
        robot.gesture("handshake")
        hand = hand_over_time(robot, "r_hand", 5.0)
        offered = hand[round(1.5 / CYCLE) : round(3.2 / CYCLE)]
        shakes, _ = find_peaks(offered[:, 2], prominence=0.02)
        assert len(shakes) == 3
        assert offered[:, 0].min() > 0.35
        assert np.abs(offered[:, 1]).max() < 0.3

    def test_a_nod_keeps_the_gaze(self) -> None:
        robot = MujocoRobot()
        run_until_ended(robot, robot.look_at((2.0, 0.8, 1.4)))
        before = robot.pan, robot.tilt
        nod = robot.gesture("nod")
        lowest = before[1]
        while nod.running:
            robot.update(robot.time + CYCLE)
            lowest = min(lowest, robot.tilt)
        assert lowest < before[1] - 0.15
        assert (robot.pan, robot.tilt) == pytest.approx(before, abs=0.02)

    @pytest.mark.parametrize("name", ["wave", "handshake", "body_cross", "grooming"])
    @pytest.mark.parametrize("after", [0.3, 1.2, 2.0])
    def test_a_cancelled_gesture_returns_home(self, name: str, after: float) -> None:
        robot = MujocoRobot()
        gesture = robot.gesture(name)
        robot.update(after)
        assert np.abs(robot.body.angles - robot.body.rest).max() > 0.1
        gesture.cancel()
        for _ in range(150):
            robot.update(robot.time + CYCLE)
            fine(robot)
        assert robot.body.angles == pytest.approx(robot.body.rest, abs=0.01)

    def test_a_stop_holds_the_arms_where_they_are(self) -> None:
        robot = MujocoRobot()
        robot.gesture("wave")
        robot.update(1.3)
        stop = robot.stop()
        run_until_ended(robot, stop)
        held = robot.body.angles.copy()
        assert np.abs(held - robot.body.rest).max() > 0.5
        robot.update(robot.time + 2.0)
        assert robot.body.angles == pytest.approx(held, abs=0.01)
        run_until_ended(robot, robot.gesture("home"))
        assert robot.body.angles == pytest.approx(robot.body.rest, abs=0.03)

    def test_one_gesture_passes_into_another(self) -> None:
        robot = MujocoRobot()
        robot.gesture("wave")
        robot.update(1.2)
        shake = robot.gesture("handshake")
        while shake.running:
            robot.update(robot.time + CYCLE)
            fine(robot)
        assert shake.status is CommandStatus.SUCCEEDED


class TestExpressions:
    def test_a_smile_lifts_the_corners_of_the_mouth(self) -> None:
        robot = MujocoRobot()
        corner = robot.body.model.body("mouth_left_corner_link").id
        before = robot.body.data.xpos[corner, 2]
        smile = robot.express("smile", 1.0)
        robot.update(EXPRESSION_SECONDS / 2)
        name, level = robot.expression
        assert name == "smile"
        assert level == pytest.approx(0.5)
        robot.update(2.0)
        assert smile.status is CommandStatus.SUCCEEDED
        after = robot.body.data.xpos[corner, 2]
        assert after > before + 0.003
        robot.express("neutral")
        robot.update(4.0)
        assert robot.body.data.xpos[corner, 2] == pytest.approx(before, abs=1e-4)


class TestDriving:
    @settings(max_examples=12, deadline=None)
    @given(start=poses, goal=poses)
    def test_it_drives_like_the_point_robot(self, start: Pose2D, goal: Pose2D) -> None:
        body, point = MujocoRobot(start), PointRobot(start)
        drives = body.go_to(goal), point.go_to(goal)
        while any(drive.running for drive in drives):
            body.update(body.time + 0.1)
            point.update(point.time + 0.1)
            assert body.time < 60
            assert body.pose.distance_to(point.pose) < 0.04
            assert abs(wrap_angle(body.pose.yaw - point.pose.yaw)) < 0.12
            fine(body)
        assert drives[0].status is drives[1].status is CommandStatus.SUCCEEDED
        assert abs(drives[0].ended - drives[1].ended) < 1.0
        assert body.pose.distance_to(goal) < 0.05
        assert abs(wrap_angle(body.pose.yaw - goal.yaw)) < 0.03

    @settings(max_examples=8, deadline=None)
    @given(
        commands=st.lists(
            st.tuples(
                st.sampled_from(["go_to", "turn_to", "look_at", "gesture", "express", "stop"]),
                poses, heights, st.integers(0, 7), st.integers(1, 60),
            ),
            min_size=1, max_size=6,
        )
    )  # fmt: skip
    def test_no_limit_is_exceeded_whatever_is_asked(
        self, commands: list[tuple[str, Pose2D, float, int, int]]
    ) -> None:
        robot = MujocoRobot()
        robot.person = (1.5, 1.5, 1.6)
        for kind, pose, height, number, cycles in commands:
            if kind == "go_to":
                robot.go_to(pose)
            elif kind == "turn_to":
                robot.turn_to(pose.yaw)
            elif kind == "look_at":
                robot.look_at((pose.x, pose.y, height))
            elif kind == "gesture":
                robot.gesture(robot.gestures[number % len(robot.gestures)])
            elif kind == "express":
                robot.express("smile", number / 7)
            else:
                robot.stop()
            for _ in range(cycles):
                robot.update(robot.time + CYCLE)
                fine(robot)
        robot.stop()
        robot.update(robot.time + 3.0)
        energy = robot.body.velocities @ robot.body.velocities
        assert energy < 1e-6  # everything has come to rest

    def test_it_keeps_away_from_a_person(self) -> None:
        robot = MujocoRobot()
        robot.person = (3.0, 0.0, 1.6)
        drive = robot.go_to(Pose2D(3.0, 0.0, 0.0))
        run_until_ended(robot, drive)
        assert drive.reason == "the goal lay within 1 m of the person"
        assert robot.pose.x == pytest.approx(2.0, abs=0.01)

    def test_the_wheels_roll_as_the_road_passes(self) -> None:
        robot = MujocoRobot()
        run_until_ended(robot, robot.go_to(Pose2D(1.0, 0.0, 0.0)))
        for wheel in ("l_wheel_joint", "r_wheel_joint"):
            turned = float(robot.body.data.joint(wheel).qpos[0])
            assert abs(turned) == pytest.approx(1.0 / 0.158, rel=0.02)

    def test_the_arms_hardly_push_the_base(self) -> None:
        robot = MujocoRobot()
        robot.gesture("wave")
        robot.update(5.0)
        assert robot.pose.distance_to(Pose2D(0.0, 0.0, 0.0)) < 0.01
        assert abs(robot.pose.yaw) < 0.01


class TestTime:
    def run(self, cut: float) -> list[FloatArray]:
        robot = MujocoRobot()
        states = []
        for second in range(6):
            if second == 0:
                robot.go_to(Pose2D(1.0, 0.5, 1.0))
                robot.gesture("wave")
            if second == 1:
                robot.look_at((2.0, 1.0, 1.5))
                robot.express("smile")
            for i in range(1, round(1 / cut) + 1):
                robot.update(second + i * cut)
            states.append(robot.body.data.qpos.copy())
        return states

    def test_the_same_calls_give_the_same_motion_to_the_last_bit(self) -> None:
        for a, b in zip(self.run(0.1), self.run(0.1), strict=True):
            assert (a == b).all()

    def test_how_time_is_cut_hardly_matters(self) -> None:
        """A look that is noticed to have arrived a little earlier ends a little earlier."""
        for a, b in zip(self.run(0.1), self.run(0.025), strict=True):
            assert a == pytest.approx(b, abs=5e-3)

    def test_a_long_wait_costs_nothing(self, monkeypatch: pytest.MonkeyPatch) -> None:
        robot = MujocoRobot()
        made: list[int] = []
        one_cycle = robot._cycle

        def cycle() -> None:
            made.append(1)
            one_cycle()

        monkeypatch.setattr(robot, "_cycle", cycle)
        drive = robot.go_to(Pose2D(1.0, 0.5, 0.0))
        looks = robot.look_at((3.0, 1.0, 1.5))
        robot.gesture("nod")
        robot.update(1.7e9)  # a robot whose clock is the time of day
        assert drive.status is looks.status is CommandStatus.SUCCEEDED
        assert len(made) < 3000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speech_rate": 0.0}, "speech_rate"),
        ({"keep_distance": math.nan}, "keep_distance"),
        ({"leash": -1.0}, "leash"),
        ({"start": Pose2D(math.inf, 0.0, 0.0)}, "start needs 3 finite numbers"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        MujocoRobot(**arguments)  # type: ignore[arg-type]
