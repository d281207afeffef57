"""PointRobot's base against closed forms and laws: profiles, limits, leash, the person's space."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robots.robot_contract import run_until_ended

from kendon.geometry import Pose2D, wrap_angle
from kendon.robots.base import CommandStatus
from kendon.robots.clearance import MEMORY
from kendon.robots.drive import STEP, BaseLimits, speed_within
from kendon.robots.point import PointRobot

LIMITS = BaseLimits()
KEEP = 1.0
near = st.floats(-4.0, 4.0)
angle = st.floats(-math.pi, math.pi)
poses = st.builds(Pose2D, near, near, angle)
people = st.tuples(near, near, st.just(1.6))


def profile_seconds(way: float, speed: float, acceleration: float) -> float:
    """How long the fastest way from standing to standing takes under both limits [s]."""
    if way < speed**2 / acceleration:
        return 2 * math.sqrt(way / acceleration)
    return way / speed + speed / acceleration


def away(robot: PointRobot) -> float:
    """From the base to the person over the ground [m]."""
    assert robot.person is not None
    return math.hypot(robot.person[0] - robot.pose.x, robot.person[1] - robot.pose.y)


class TestClosedForm:
    @pytest.mark.parametrize("way", [0.1, 0.3, 0.5, 1.0, 4.0])
    def test_a_straight_drive_takes_the_time_of_its_trapezoid(self, way: float) -> None:
        robot = PointRobot()
        drive = robot.go_to(Pose2D(way, 0.0, 0.0))
        while drive.running:
            robot.update(robot.time + 0.01)
        expected = profile_seconds(way, LIMITS.speed, LIMITS.acceleration)
        assert expected - 0.01 <= drive.ended <= expected + 0.03
        assert robot.pose.x == pytest.approx(way, abs=1e-6)

    @pytest.mark.parametrize("yaw", [0.2, -0.5, 1.0, -3.0])
    def test_a_turn_takes_the_time_of_its_trapezoid(self, yaw: float) -> None:
        robot = PointRobot()
        turn = robot.turn_to(yaw)
        while turn.running:
            robot.update(robot.time + 0.01)
        expected = profile_seconds(abs(yaw), LIMITS.turn_rate, LIMITS.turn_acceleration)
        assert expected - 0.01 <= turn.ended <= expected + 0.03
        assert tuple(robot.pose) == pytest.approx((0.0, 0.0, yaw), abs=1e-6)

    def test_along_the_way_it_follows_the_trapezoid(self) -> None:
        robot = PointRobot()
        robot.go_to(Pose2D(2.0, 0.0, 0.0))
        for t, x, v in (
            (0.5, 0.0625, 0.25),
            (1.0, 0.25, 0.5),
            (3.0, 1.25, 0.5),
            (4.5, 1.9375, 0.25),
        ):
            robot.update(t)
            assert robot.pose.x == pytest.approx(x, abs=1e-3)
            assert robot.speed == pytest.approx(v, abs=LIMITS.acceleration * STEP / 10)

    def test_stop_brakes_at_the_limit(self) -> None:
        robot = PointRobot()
        robot.go_to(Pose2D(3.0, 0.0, 0.0))
        robot.update(2.0)
        x = robot.pose.x
        stop = robot.stop()
        run_until_ended(robot, stop)
        assert stop.ended == pytest.approx(2.0 + LIMITS.speed / LIMITS.acceleration, abs=0.11)
        assert robot.pose.x - x == pytest.approx(LIMITS.speed**2 / 2 / LIMITS.acceleration)

    @given(
        road=st.floats(0.001, 5.0), share=st.floats(0.0, 1.0), a=st.floats(0.1, 5.0),
        h=st.floats(0.001, 0.1), closing=st.floats(0.0, 2.0),
    )  # fmt: skip
    def test_the_braking_rule_uses_up_the_road_exactly(
        self, road: float, share: float, a: float, h: float, closing: float
    ) -> None:
        v = share * math.sqrt(2 * a * road)
        v2 = speed_within(road, v, a, h, closing)
        used = (v + v2) / 2 * h + v2**2 / (2 * a) + closing * (h + v2 / a)
        if v2 > 0:
            assert used == pytest.approx(road)
        else:
            assert used >= road * (1 - 1e-9)


class TestReachingGoals:
    @settings(max_examples=60, deadline=None)
    @given(start=poses, goal=poses)
    def test_every_goal_is_reached(self, start: Pose2D, goal: Pose2D) -> None:
        robot = PointRobot(start)
        drive = robot.go_to(goal)
        run_until_ended(robot, drive, 60.0)
        assert (drive.status, drive.reason) == (CommandStatus.SUCCEEDED, "")
        assert drive.sent["goal"] == Pose2D(goal.x, goal.y, wrap_angle(goal.yaw))
        assert robot.pose.distance_to(goal) <= 0.05
        assert abs(wrap_angle(robot.pose.yaw - goal.yaw)) <= 0.02
        assert (robot.speed, robot.turn_rate) == (0.0, 0.0)

    @settings(max_examples=40, deadline=None)
    @given(goal=poses)
    def test_how_time_is_cut_hardly_matters(self, goal: Pose2D) -> None:
        """10 Hz and 100 Hz: 3 cm and 0.1 rad on the way, 5 mm and the yaw tolerance at the end.

        For a goal a few millimetres outside the position tolerance the steps decide how soon the
        base is inside, and so when it turns to the goal's yaw: there the way's yaws may differ.
        """
        hair = 0.05 < math.hypot(goal.x, goal.y) < 0.057
        slow, fast = PointRobot(), PointRobot()
        drives = slow.go_to(goal), fast.go_to(goal)
        for i in range(1, 301):
            slow.update(i / 10)
            for j in range(9, -1, -1):
                fast.update(i / 10 - j / 100)
            assert slow.pose.distance_to(fast.pose) < 0.03
            assert hair or abs(wrap_angle(slow.pose.yaw - fast.pose.yaw)) < 0.1
            if not any(d.running for d in drives):
                break
        assert all(d.status is CommandStatus.SUCCEEDED for d in drives)
        assert slow.pose.distance_to(fast.pose) < 0.005
        assert abs(wrap_angle(slow.pose.yaw - fast.pose.yaw)) < 0.02

    def test_the_same_calls_give_the_same_poses(self) -> None:
        runs = []
        for _ in range(2):
            robot = PointRobot()
            robot.go_to(Pose2D(2.0, 1.0, 3.0))
            poses = []
            for i in range(200):
                robot.update(i * 0.07)
                poses.append(robot.pose)
            runs.append(poses)
        assert runs[0] == runs[1]

    def test_a_goal_close_behind_is_reached_in_reverse(self) -> None:
        robot = PointRobot()
        drive = robot.go_to(Pose2D(-0.4, 0.0, 0.0))
        while drive.running:
            robot.update(robot.time + 0.05)
            assert robot.speed <= 0
            assert abs(robot.pose.yaw) < 1e-6
        assert robot.pose.x == pytest.approx(-0.4, abs=1e-6)

    def test_a_goal_that_moves_at_10_hz_is_followed_without_a_break(self) -> None:
        robot = PointRobot()
        for i in range(60):
            goal = Pose2D(3.0 + 0.02 * i, 0.01 * i, 0.0)
            robot.go_to(goal)
            before = robot.speed
            robot.update((i + 1) / 10)
            assert robot.speed >= before - 1e-3
        assert robot.speed == pytest.approx(LIMITS.speed, rel=0.01)

    def test_a_goal_that_jitters_leaves_a_robot_that_is_there_in_peace(self) -> None:
        robot = PointRobot()
        for i in range(100):
            robot.go_to(Pose2D(1.0 + 0.02 * math.sin(7 * i), 0.02 * math.cos(5 * i), 0.0))
            robot.update((i + 1) / 10)
            if i > 50:
                assert robot.speed == 0.0
                assert abs(robot.pose.yaw) < 0.05

    def test_it_holds_still_when_there_is_nothing_to_do(self) -> None:
        robot = PointRobot(Pose2D(1.0, 2.0, 0.5))
        robot.person = (1.2, 2.0, 1.6)
        for i in range(1, 50):
            robot.update(i / 10)
        assert robot.pose == Pose2D(1.0, 2.0, 0.5)


class TestLimits:
    @settings(max_examples=60, deadline=None)
    @given(
        goals=st.lists(st.tuples(poses, st.integers(1, 40)), min_size=1, max_size=6),
        dt=st.sampled_from([0.01, 0.033, 0.1, 0.25]),
    )
    def test_no_speed_or_acceleration_is_ever_exceeded(
        self, goals: list[tuple[Pose2D, int]], dt: float
    ) -> None:
        robot = PointRobot()
        robot.person = (1.5, 1.5, 1.6)
        for goal, steps in goals:
            robot.go_to(goal)
            for _ in range(steps):
                pose, v, w = robot.pose, robot.speed, robot.turn_rate
                robot.update(robot.time + dt)
                assert abs(robot.speed) <= LIMITS.speed + 1e-9
                assert abs(robot.turn_rate) <= LIMITS.turn_rate + 1e-9
                assert abs(robot.speed - v) <= LIMITS.acceleration * dt + 1e-6
                assert abs(robot.turn_rate - w) <= LIMITS.turn_acceleration * dt + 1e-6
                assert robot.pose.distance_to(pose) <= LIMITS.speed * dt + 1e-9
                turned = abs(wrap_angle(robot.pose.yaw - pose.yaw))
                assert turned <= LIMITS.turn_rate * dt + 1e-9


class TestLeash:
    @settings(max_examples=60, deadline=None)
    @given(
        start=poses,
        goals=st.lists(st.tuples(poses, st.integers(1, 60)), min_size=1, max_size=5),
        leash=st.floats(0.0, 3.0),
    )
    def test_the_base_stays_on_it(
        self, start: Pose2D, goals: list[tuple[Pose2D, int]], leash: float
    ) -> None:
        robot = PointRobot(start, leash=leash)
        for goal, steps in goals:
            drive = robot.go_to(goal)
            assert start.distance_to(drive.sent["goal"]) <= leash + 1e-9
            for _ in range(steps):
                robot.update(robot.time + 0.1)
                assert start.distance_to(robot.pose) <= leash + 1e-6
        run_until_ended(robot, robot.go_to(goals[-1][0]), 60.0)
        assert robot.pose.distance_to(robot.log[-1].sent["goal"]) <= 0.05

    def test_a_leash_of_nothing_only_turns(self) -> None:
        robot = PointRobot(leash=0.0)
        drive = robot.go_to(Pose2D(3.0, 1.0, 1.0))
        assert drive.sent["goal"] == Pose2D(0.0, 0.0, 1.0)
        run_until_ended(robot, drive)
        assert drive.reason == "the goal lay beyond the leash of 0 m"
        assert tuple(robot.pose) == pytest.approx((0.0, 0.0, 1.0))


class TestThePersonsSpace:
    def test_a_goal_on_the_person_is_moved_back_along_the_line(self) -> None:
        robot = PointRobot()
        robot.person = (4.0, 3.0, 1.6)
        drive = robot.go_to(Pose2D(4.0, 3.0, 0.0))
        assert drive.sent["goal"] == (pytest.approx(3.2), pytest.approx(2.4), 0.0)
        run_until_ended(robot, drive, 30.0)
        assert drive.status is CommandStatus.SUCCEEDED
        assert drive.reason == "the goal lay within 1 m of the person"
        assert away(robot) == pytest.approx(KEEP, abs=1e-3)

    @settings(max_examples=60, deadline=None)
    @given(
        person=people,
        goals=st.lists(st.tuples(poses, st.integers(1, 60)), min_size=1, max_size=5),
        dt=st.sampled_from([0.02, 0.1]),
    )
    def test_it_never_drives_into_a_person_who_stands(
        self, person: tuple[float, float, float], goals: list[tuple[Pose2D, int]], dt: float
    ) -> None:
        robot = PointRobot()
        robot.person = person
        closest = min(away(robot), KEEP)
        for goal, steps in goals:
            drive = robot.go_to(goal)
            sent = drive.sent["goal"]
            assert sent[:2] == robot.pose[:2] or math.dist(sent[:2], person[:2]) >= KEEP - 1e-6
            for _ in range(steps):
                robot.update(robot.time + dt)
                assert away(robot) >= closest - 1e-6
        drive = robot.go_to(goals[-1][0])
        run_until_ended(robot, drive, 90.0)
        assert away(robot) >= closest - 1e-6

    @settings(max_examples=60, deadline=None)
    @given(person=people, goal=poses, walk=st.floats(0.0, 1.5), course=angle)
    def test_it_stands_before_a_person_who_walks_steadily_is_there(
        self, person: tuple[float, float, float], goal: Pose2D, walk: float, course: float
    ) -> None:
        robot = PointRobot()
        robot.person = person
        robot.go_to(goal)
        for i in range(1, 100):
            t = i / 10
            x, y = person[0] + walk * t * math.cos(course), person[1] + walk * t * math.sin(course)
            robot.person = (x, y, 1.6)
            pose = robot.pose
            if away(robot) < KEEP:
                # They have come in by themselves, to a base that stands, leaves, or almost so:
                # the way of one who walks past is foreseen from samples 0.1 s apart.
                ahead = math.cos(math.atan2(y - pose.y, x - pose.x) - pose.yaw)
                assert robot.speed * ahead <= 0.25
                break
            robot.update(t)
            assert away(robot) >= KEEP - 0.02

    @settings(max_examples=60, deadline=None)
    @given(
        person=people, goal=poses,
        moves=st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)), max_size=80),
    )  # fmt: skip
    def test_whatever_the_person_does_it_brakes_at_its_limit_or_keeps_away(
        self,
        person: tuple[float, float, float],
        goal: Pose2D,
        moves: list[tuple[float, float]],
    ) -> None:
        robot = PointRobot()
        robot.person = person
        robot.go_to(goal)
        x, y, _ = person
        for i, (dx, dy) in enumerate(moves, 1):
            x, y = x + dx, y + dy
            robot.person = (x, y, 1.6)
            old, v = math.hypot(x - robot.pose.x, y - robot.pose.y), abs(robot.speed)
            robot.update(i / 10)
            braking = abs(robot.speed) <= max(0.0, v - LIMITS.acceleration * 0.1) + 1e-6
            assert braking or away(robot) >= min(KEEP, old) - 1e-6

    def test_it_does_not_flee_and_may_still_turn(self) -> None:
        robot = PointRobot()
        for i in range(1, 40):
            robot.person = (max(0.3, 3.0 - 0.1 * i), 0.0, 1.6)
            robot.update(i / 10)
        assert robot.pose == Pose2D(0.0, 0.0, 0.0)
        turn = robot.turn_to(1.0)
        run_until_ended(robot, turn)
        assert tuple(robot.pose) == pytest.approx((0.0, 0.0, 1.0))
        approach = robot.go_to(Pose2D(0.2, 0.0, 0.0))
        assert approach.sent["goal"] == Pose2D(0.0, 0.0, 0.0)
        leave = robot.go_to(Pose2D(-2.0, 0.0, 0.0))
        run_until_ended(robot, leave)
        assert leave.status is CommandStatus.SUCCEEDED

    def test_a_person_who_walks_onto_the_goal_is_met_at_the_edge_of_their_space(self) -> None:
        robot = PointRobot()
        robot.person = (5.0, 0.0, 1.6)
        drive = robot.go_to(Pose2D(4.0, 0.0, 0.0))
        while drive.running:
            robot.person = (max(3.3, 5.0 - 0.5 * robot.time), 0.0, 1.6)
            robot.update(robot.time + 0.1)
        assert drive.status is CommandStatus.SUCCEEDED
        assert drive.reason == "the person has come within 1 m of the goal"
        assert 0.99 * KEEP <= away(robot) <= KEEP + 0.02

    def test_it_drives_around_a_person_in_the_way(self) -> None:
        robot = PointRobot()
        robot.person = (2.0, 0.1, 1.6)
        drive = robot.go_to(Pose2D(4.0, 0.0, 0.0))
        while drive.running:
            robot.update(robot.time + 0.1)
            assert away(robot) >= KEEP - 1e-6
        assert drive.status is CommandStatus.SUCCEEDED
        assert drive.ended < 15.0

    def test_it_gives_up_before_a_person_who_bars_the_way(self) -> None:
        robot = PointRobot()
        robot.person = (0.6, 0.0, 1.6)
        drive = robot.go_to(Pose2D(3.0, 0.0, 0.0))
        run_until_ended(robot, drive)
        assert drive.status is CommandStatus.FAILED
        assert drive.reason == "the person has barred the way for 5 s"
        assert drive.ended == pytest.approx(5.0, abs=0.11)
        assert robot.pose == Pose2D(0.0, 0.0, 0.0)

    def test_it_goes_on_when_the_way_is_free_again(self) -> None:
        robot = PointRobot()
        robot.person = (0.6, 0.0, 1.6)
        drive = robot.go_to(Pose2D(3.0, 0.0, 0.0))
        robot.update(3.0)
        assert drive.running
        robot.person = None
        run_until_ended(robot, drive)
        assert drive.status is CommandStatus.SUCCEEDED

    def test_a_person_whose_track_goes_quiet_counts_as_standing(self) -> None:
        robot = PointRobot()
        drive = robot.go_to(Pose2D(3.0, 0.0, 0.0))
        for i in range(1, 10):
            robot.person = (6.0 - 0.1 * i, 0.0, 1.6)
            robot.update(i / 10)
        robot.update(robot.time + 2 * MEMORY)
        run_until_ended(robot, drive)
        assert robot.pose.x == pytest.approx(3.0, abs=0.05)

    def test_an_unknown_position_is_no_person(self) -> None:
        robot = PointRobot()
        robot.person = (math.nan, math.nan, math.nan)
        drive = robot.go_to(Pose2D(1.0, 0.0, 0.0))
        run_until_ended(robot, drive)
        assert drive.status is CommandStatus.SUCCEEDED
