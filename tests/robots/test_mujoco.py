"""MujocoRobot: the contract, and its body against closed forms, limits and PointRobot."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robots.robot_contract import RobotContract, run_until_ended
from scipy.signal import find_peaks
from scipy.spatial.transform import Rotation

from kendon.errors import ParameterError
from kendon.geometry import Pose2D, Vec3, wrap_angle
from kendon.person import FloatArray
from kendon.robots.base import CommandStatus, Robot
from kendon.robots.mujoco import MujocoRobot, read_description
from kendon.robots.mujoco.body import CYCLE
from kendon.robots.mujoco.robot import EXPRESSION_SECONDS
from kendon.robots.point import PointRobot

SIMPLE = Path(__file__).resolve().parents[2] / "examples" / "robot" / "pan_tilt.toml"
EYES = ("l_eye", "r_eye")
near = st.floats(-2.5, 2.5)
angle = st.floats(-math.pi, math.pi)
poses = st.builds(Pose2D, near, near, angle)
heights = st.floats(0.0, 2.2)


class SimpleRobot(MujocoRobot):
    """The example: one arm, and a tilt joint that looks down in its positive direction."""

    def __init__(self, start: Pose2D = Pose2D(0.0, 0.0, 0.0), *, patience: float = 5.0) -> None:
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
        assert robot.expression == ("smile", pytest.approx(0.5))
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
        for a, b in zip(self.run(0.1), self.run(0.02), strict=True):
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
        robot.gesture("nod")
        robot.update(1.7e9)  # a robot whose clock is the time of day
        assert drive.status is CommandStatus.SUCCEEDED
        assert len(made) < 3000


# ---- the model of Vizzy, link by link, against the maker's numbers

#: Name of the joint: parent, child, xyz [m], rpy [rad], lowest and highest [rad], speed [rad/s];
#: 1.571 and 3.142 stand for right and straight angles.
LINKS = """
r_wheel_joint base_link r_wheel_link 0.1899 0.245 0.1581 1.571 1.571 0
l_wheel_joint base_link l_wheel_link 0.1899 -0.245 0.1581 1.571 1.571 0
waist_joint base_link waist_link 0.1935 0 0.5407 1.571 0 0 -0.349 0.349 0.593
neck_pan_joint waist_link neck_pan_link 0 0 0 1.571 0 0 -2.03 2.03 5
neck_tilt_joint neck_pan_link neck_tilt_link 0 0 -0.37 1.571 0 0 -2.01 2.46 5
eyes_tilt_joint neck_tilt_link eyes_tilt_link -0.1238 -0.04755 0 3.142 0 -2.772 -0.663 0.663 5
eyes_center_joint eyes_tilt_link eyes_center_link 0 0 0 1.571 0 0.3696
l_eye_joint eyes_center_link l_eye_link 0 0.102 0 0 3.142 0 -1 1 5
r_eye_joint eyes_center_link r_eye_link 0 -0.102 0 0 3.142 0 -1 1 5
l_shoulder_scapula_joint waist_link l_shoulder_scapula_link 0 0 0.0805 1.571 0 -0.0175 -0.314 0.314 3
l_shoulder_flection_joint l_shoulder_scapula_link l_shoulder_flection_link 0 0 -0.212 1.571 0 0 -1.31 2.36 3
l_shoulder_abduction_joint l_shoulder_flection_link l_shoulder_abduction_link 0 0 -0.1026 1.571 0 -1.571 0 1.31 3
l_shoulder_rotation_joint l_shoulder_abduction_link l_shoulder_rotation_link 0 0 0 1.571 0 1.92 -1.48 1.48 3
l_elbow_flection_joint l_shoulder_rotation_link l_elbow_flection_link 0 0 -0.163 1.571 0 1.571 0 1.92 3
l_forearm_pronation_joint l_elbow_flection_link l_forearm_pronation_link 0 0 0 1.571 0 0.0873 -1.48 1.48 3
l_wrist_abduction_joint l_forearm_pronation_link l_wrist_abduction_link 0 0 0.1893 1.571 0 0 -0.611 0.611 3
l_wrist_flection_joint l_wrist_abduction_link l_wrist_flection_link 0 0 0 1.571 0 -1.571 -0.611 0.611 3
r_shoulder_scapula_joint waist_link r_shoulder_scapula_link 0 0 -0.0805 1.571 0 3.124 -0.314 0.314 3
r_shoulder_flection_joint r_shoulder_scapula_link r_shoulder_flection_link 0 0 0.212 1.571 0 0 -1.31 2.36 3
r_shoulder_abduction_joint r_shoulder_flection_link r_shoulder_abduction_link 0 0 0.1026 1.571 0 -1.571 0 1.31 3
r_shoulder_rotation_joint r_shoulder_abduction_link r_shoulder_rotation_link 0 0 0 1.571 0 1.92 -1.48 1.48 3
r_elbow_flection_joint r_shoulder_rotation_link r_elbow_flection_link 0 0 0.163 1.571 0 1.571 0 1.92 3
r_forearm_pronation_joint r_elbow_flection_link r_forearm_pronation_link 0 0 0 1.571 0 0.0873 -1.48 1.48 3
r_wrist_abduction_joint r_forearm_pronation_link r_wrist_abduction_link 0 0 -0.1893 1.571 0 0 -0.611 0.611 3
r_wrist_flection_joint r_wrist_abduction_link r_wrist_flection_link 0 0 0 1.571 0 -1.571 -0.611 0.611 3
"""  # noqa: E501


class TestVizzysModel:
    links = tuple(line.split() for line in LINKS.strip().splitlines())
    right_angles = {"1.571": math.pi / 2, "-1.571": -math.pi / 2, "3.142": math.pi}  # noqa: RUF012

    @settings(max_examples=20, deadline=None)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_every_link_is_where_the_composed_transforms_put_it(self, seed: int) -> None:
        body = MujocoRobot().body
        rng = np.random.default_rng(seed)
        angles = {
            joint: rng.uniform(float(rest[6]), float(rest[7])) if len(rest) > 6 else 0.0
            for joint, _, _, *rest in self.links
        }
        for joint, value in angles.items():
            if joint != "eyes_center_joint":  # a fixed one
                body.data.joint(joint).qpos = value
        mujoco.mj_kinematics(body.model, body.data)
        # base_footprint to base_link: the maker's, without the 4 cm below the floor.
        frames = {"base_link": (np.array([0.1935, 0.0, 0.0]), Rotation.from_euler("z", math.pi))}
        for joint, parent, child, *rest in self.links:
            place, turn = frames[parent]
            xyz = np.array([float(v) for v in rest[:3]])
            rpy = [self.right_angles.get(v, float(v)) for v in rest[3:6]]
            frames[child] = (
                place + turn.apply(xyz),
                turn * Rotation.from_euler("xyz", rpy) * Rotation.from_rotvec([0, 0, angles[joint]]),
            )
            found = body.data.body(child)
            assert found.xpos == pytest.approx(frames[child][0], abs=5e-4)
            off = Rotation.from_matrix(found.xmat.reshape(3, 3)).inv() * frames[child][1]
            assert off.magnitude() < 1e-3

    def test_ranges_and_speeds_are_the_makers(self) -> None:
        body = MujocoRobot().body
        for joint, _, _, *rest in self.links:
            if len(rest) > 6:
                i = body.index("test", joint)
                low, high, speed = (float(v) for v in rest[6:9])
                assert (body.low[i], body.high[i], body.speeds[i]) == (low, high, speed)

    def test_it_has_thirty_degrees_of_freedom_and_a_mouth(self) -> None:
        body = MujocoRobot().body
        moved = [name for name in body.joints if not name.startswith("mouth")]
        wheels = 2
        assert len(moved) + wheels == 30
        assert sum(name.startswith(("l_wrist", "l_shoulder", "l_elbow", "l_forearm"))
                   for name in moved) == 8  # fmt: skip
        assert body.model.nv == 3 + wheels + len(body.joints)  # 3: the base over the floor

    def test_it_stands_on_the_floor_and_is_as_tall_as_a_child(self) -> None:
        robot = MujocoRobot()
        model, data = robot.body.model, robot.body.data
        tops = data.geom_xpos[:, 2] + model.geom_rbound
        assert 1.0 < tops.max() < 1.4
        wheel = data.body("l_wheel_link").xpos[2]
        assert wheel - 0.158 == pytest.approx(0.0, abs=1e-3)
        assert robot.face[2] == pytest.approx(0.5407 + 0.37 + 0.04755, abs=1e-4)


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
