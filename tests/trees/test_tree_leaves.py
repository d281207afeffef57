"""The leaves: what they send, how often, and what ends it."""

from __future__ import annotations

import math

import pytest
from py_trees.common import Status
from trees.tree_fakes import Stage, TeleportRobot, close, one_tree

from kendon.errors import RobotError, TreeError
from kendon.geometry import UNKNOWN_ROTATION, Pose2D, yaw_quaternion
from kendon.greeter import Flow
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.robots import PointRobot
from kendon.robots.base import CommandKind, CommandStatus
from kendon.trees import GreetingTree, Pose, TickContext
from kendon.trees.commands import RETRY_AFTER

FACE = '<GetPoseFromFace closest_face="{face}"/>'
GAZE = f'<ReactiveSequence>{FACE}<GazeAtTarget fixation_pose="{{face}}"/></ReactiveSequence>'
APPROACH = (
    f'<ReactiveSequence>{FACE}<GetApproachCoords closest_face="{{face}}" goal_pose="{{goal}}"/>'
    '<MoveBase goal_pose="{goal}"/></ReactiveSequence>'
)
TURN = (
    f'<ReactiveSequence>{FACE}<TurnToPersonCoords closest_face="{{face}}" goal_pose="{{goal}}"/>'
    '<MoveBase goal_pose="{goal}"/></ReactiveSequence>'
)


@pytest.mark.parametrize("phase", Phase)
def test_get_state_writes_the_thesis_number_as_text(phase: Phase) -> None:
    stage = Stage('<GetState state="{state}"/>')
    assert stage.run(phase) is Status.SUCCESS
    assert stage.tree.blackboard == {"state": str(phase.value)}


def test_get_state_fails_without_a_belief() -> None:
    stage = Stage('<GetState state="{state}"/>')
    assert stage.run(None) is Status.FAILURE
    assert stage.message("GetState") == "there is no belief about the phase yet"


def test_the_face_carries_its_frame() -> None:
    for frame, wanted in (("map", (4, 1, 1.7)), ("base_footprint", (1, -3, 1.7))):
        stage = Stage(f'<GetPoseFromFace closest_face="{{face}}" frame_id="{frame}"/>')
        assert isinstance(stage.robot, TeleportRobot)
        stage.robot.place = Pose2D(1, 0, math.pi / 2)
        stage.rotation = yaw_quaternion(math.pi)
        stage.run(None)
        face = stage.tree.blackboard["face"]
        assert isinstance(face, Pose)
        assert face.frame == frame
        assert face.position == pytest.approx(wanted)
        world = face.in_world(stage.robot.pose)
        assert abs(math.remainder(world.yaw - math.pi, 2 * math.pi)) < 1e-9


def test_a_face_is_kept_for_its_patience_and_no_longer() -> None:
    stage = Stage(FACE.replace("/>", ' patience="0.3"/>'))
    assert stage.run(None) is Status.SUCCESS
    stage.face = None
    assert stage.run(None, 0.2) is Status.SUCCESS
    assert stage.run(None, 0.2) is Status.FAILURE
    assert stage.message("GetPoseFromFace") == "no face has been seen for 0.4 s"


def test_no_face_yet() -> None:
    stage = Stage(FACE)
    stage.face = None
    assert stage.run(None) is Status.FAILURE
    assert stage.message("GetPoseFromFace") == "no face has been seen yet"


def test_a_face_of_unknown_height_is_level_with_the_robots() -> None:
    stage = Stage(GAZE)
    stage.face = (2.0, 0.0, math.nan)
    stage.run(None)
    assert stage.sent()[0].asked["point"] == (2.0, 0.0, 1.2)


def test_gaze_down_halves_the_height() -> None:
    stage = Stage(
        f'<Sequence>{FACE}<GazeDownCoords closest_face="{{face}}" fixation_pose="{{down}}"/>'
        '<GazeAtTarget fixation_pose="{down}"/></Sequence>'
    )
    stage.run(None)
    assert stage.sent()[0].asked["point"] == (4.0, 1.0, 0.85)


# ---- MoveBase


def test_the_robot_turns_on_the_spot_to_the_person() -> None:
    stage = Stage(TURN)
    assert stage.run(None) is Status.RUNNING
    assert stage.run(None, 2.0) is Status.SUCCESS
    (command,) = stage.sent()
    assert command.kind is CommandKind.TURN_TO
    assert command.asked["yaw"] == pytest.approx(math.atan2(1, 4))


def test_one_goal_is_sent_once_however_long_it_is_ticked() -> None:
    stage = Stage(APPROACH)
    stage.rotation = yaw_quaternion(math.pi)
    assert stage.run(None, 0.5) is Status.RUNNING
    assert stage.run(None, 5.0) is Status.SUCCESS
    (command,) = stage.sent()
    assert command.kind is CommandKind.GO_TO
    assert close(command.asked["goal"], Pose2D(3, 1, 0))


def test_a_goal_is_sent_again_only_when_it_has_moved_by_more_than_the_tolerance() -> None:
    stage = Stage(APPROACH, TeleportRobot(delay=100.0))
    stage.rotation = yaw_quaternion(math.pi)
    stage.run(None)
    for x, wanted in ((4.09, 1), (3.91, 1), (4.11, 2), (4.19, 2), (4.0, 3)):
        stage.face = (x, 1.0, 1.7)
        stage.run(None, 0.3)
        assert len(stage.sent()) == wanted
    stage.rotation = yaw_quaternion(math.pi + 0.09)
    stage.run(None)
    assert len(stage.sent()) == 3
    assert [c.status for c in stage.sent()[:2]] == [CommandStatus.CANCELLED] * 2


def test_a_turn_of_more_than_the_tolerance_is_a_new_goal() -> None:
    stage = Stage(TURN, TeleportRobot(delay=100.0))
    stage.run(None)
    before = math.atan2(1, 4)
    for turn, wanted in ((0.09, 1), (0.11, 2)):
        stage.face = (4 * math.cos(before + turn), 4 * math.sin(before + turn), 1.7)
        stage.run(None)
        assert len(stage.sent()) == wanted


def test_a_robot_that_is_there_already_gets_no_command() -> None:
    stage = Stage(TURN)
    stage.face = (4.0, 0.2, 1.7)
    assert stage.run(None, 1.0) is Status.SUCCESS
    assert stage.sent() == []
    assert stage.message("MoveBase") == "already there"


def test_a_goal_written_out_in_either_frame() -> None:
    for frame, wanted in (("map", (2.0, 0.0)), ("base_footprint", (1.0, 2.0)), ("", (2.0, 0.0))):
        stage = Stage(f'<MoveBase goal_pose="2;0;0" frame_id="{frame}"/>')
        assert isinstance(stage.robot, TeleportRobot)
        stage.robot.place = Pose2D(1, 0, math.pi / 2)
        stage.run(None)
        goal = stage.sent()[0].asked["goal"]
        assert (goal.x, goal.y) == pytest.approx(wanted)
        assert goal.yaw == pytest.approx(math.pi / 2)  # no heading written: it keeps its own


# ---- GazeAtTarget


def test_the_gaze_follows_the_face_beyond_its_tolerance() -> None:
    stage = Stage(GAZE)
    assert stage.run(None, 2.0) is Status.SUCCESS
    assert len(stage.sent()) == 1
    stage.face = (4.0, 1.04, 1.7)
    assert stage.run(None) is Status.SUCCESS
    stage.face = (4.0, 1.06, 1.7)
    assert stage.run(None) is Status.RUNNING
    assert len(stage.sent()) == 2


def test_the_tolerance_is_a_port() -> None:
    stage = Stage(
        GAZE.replace("fixation_pose", 'fixation_point_error_tolerance="0.5" fixation_pose')
    )
    stage.run(None, 1.0)
    stage.face = (4.0, 1.4, 1.7)
    stage.run(None)
    assert len(stage.sent()) == 1


def test_the_head_looks_again_when_the_base_has_turned_under_it() -> None:
    stage = Stage(GAZE)
    assert isinstance(stage.robot, TeleportRobot)
    stage.run(None, 1.0)
    stage.robot.place = Pose2D(0, 0, 0.09)
    stage.run(None)
    assert len(stage.sent()) == 1
    stage.robot.place = Pose2D(0, 0, 0.2)
    stage.run(None, 1.0)
    assert len(stage.sent()) == 2


# ---- ArmRoutines, Express, Speak, Wait


@pytest.mark.parametrize(("text", "name"), [("WAVE", "wave"), ("3", "handshake"), ("2", "stretch")])
def test_a_gesture_succeeds_when_it_begins(text: str, name: str) -> None:
    stage = Stage(f'<ArmRoutines gesture="{text}"/>')
    assert stage.run(None) is Status.SUCCESS
    (command,) = stage.sent()
    assert (command.kind, command.asked) == (CommandKind.GESTURE, {"name": name})
    assert command.running


def test_a_gesture_starts_anew_every_round_and_a_posture_does_not() -> None:
    for gesture, wanted in (("WAVE", 3), ("HOME", 1)):
        body = f'<ArmRoutines gesture="{gesture}"/><WaitForXSeconds seconds="1"/>'
        stage = Stage(f'<Repeat num_cycles="3"><Sequence>{body}</Sequence></Repeat>')
        while stage.run(None) is Status.RUNNING:
            pass
        assert [c.asked["name"] for c in stage.sent()] == [gesture.lower()] * wanted


def test_a_sequence_that_starts_over_does_not_cancel_the_gesture_it_began() -> None:
    for kind in ("Sequence", "ReactiveSequence", "SequenceWithMemory"):
        stage = Stage(
            f'<{kind}><ArmRoutines gesture="HOME"/><AlwaysFailure/></{kind}>',
            TeleportRobot(delay=3.0),
        )
        stage.run(None, 2.0)
        (command,) = stage.sent()
        assert command.running, kind
        stage.tree.halt()
        assert command.status is CommandStatus.CANCELLED
        assert command.reason == "the tree was halted"


def test_a_gesture_the_robot_does_not_have() -> None:
    stage = Stage('<ArmRoutines gesture="ANGRY"/>')
    assert stage.run(None) is Status.FAILURE
    assert stage.message("ArmRoutines").startswith(
        "there is no gesture 'angry'; valid: home, wave, handshake, stretch"
    )


def test_an_expression_is_sent_when_it_changes() -> None:
    stage = Stage('<Express expression="{e}" intensity="{i}"/>')
    scope = stage.tree._scope
    for expression, intensity, wanted in (
        ("neutral", 1.0, 1),
        ("smile", 1.0, 2),
        ("smile", 0.5, 3),
        ("smile", 0.5, 3),
    ):
        scope.entry("e").value, scope.entry("i").value = expression, intensity
        assert stage.run(None, 0.3) is Status.SUCCESS
        assert len(stage.sent()) == wanted


def test_a_robot_without_the_expression_does_without() -> None:
    stage = Stage('<Express expression="frown"/>')
    assert stage.run(None) is Status.SUCCESS
    assert stage.sent() == []
    assert stage.message("Express") == "this robot does not show 'frown'"


def test_speak_runs_until_it_has_been_said() -> None:
    stage = Stage('<Speak utterance="Muito prazer" language="pt"/>')
    assert stage.run(None, 0.5) is Status.RUNNING
    assert stage.run(None) is Status.SUCCESS
    (command,) = stage.sent()
    assert command.asked == {"text": "Muito prazer", "language": "pt"}
    stage.run(None)
    assert len(stage.sent()) == 2  # a new round


def test_speak_of_nothing_fails_with_the_robots_sentence() -> None:
    stage = Stage('<Speak utterance=""/>')
    assert stage.run(None) is Status.FAILURE
    assert stage.message("Speak") == "say needs a text; an empty one was given"


@pytest.mark.parametrize("result", ["SUCCESS", "FAILURE"])
def test_wait_counts_the_flows_seconds(result: str) -> None:
    stage = Stage(f'<WaitForXSeconds seconds="1.2" result="{result}"/>')
    assert stage.run(None, 1.2) is Status.RUNNING
    assert stage.run(None) is Status[result]


def test_wait_without_end() -> None:
    stage = Stage('<WaitForXSeconds seconds="inf"/>')
    assert stage.run(None, 100.0) is Status.RUNNING


# ---- robots that fail


LEAVES = {
    CommandKind.GO_TO: (APPROACH, "MoveBase"),
    CommandKind.LOOK_AT: (GAZE, "GazeAtTarget"),
    CommandKind.GESTURE: ('<ArmRoutines gesture="HOME"/>', "ArmRoutines"),
    CommandKind.SAY: ('<Speak utterance="Hi"/>', "Speak"),
    CommandKind.EXPRESS: ('<Express expression="smile"/>', "Express"),
}


@pytest.mark.parametrize("kind", LEAVES)
def test_a_refused_command_fails_its_leaf_and_is_tried_again_after_a_pause(
    kind: CommandKind,
) -> None:
    body, leaf = LEAVES[kind]
    robot = TeleportRobot()
    robot.refuses = (kind,)
    stage = Stage(body, robot)
    assert stage.run(None, RETRY_AFTER) is Status.FAILURE
    assert len(stage.sent()) == 1
    assert stage.message(leaf).endswith(f"failed: no {kind.value} today")
    robot.refuses = ()
    assert stage.run(None, 0.2) is not Status.FAILURE
    assert stage.sent()[0].status is CommandStatus.FAILED
    assert len(stage.sent()) == 2


@pytest.mark.parametrize("kind", LEAVES)
def test_a_robot_that_does_not_answer_fails_the_leaf_with_its_reason(kind: CommandKind) -> None:
    body, leaf = LEAVES[kind]
    stage = Stage(body, TeleportRobot(mute=[kind]))
    stage.run(None, 5.3)
    assert stage.status(leaf) == "failure"
    assert stage.message(leaf).endswith("failed: the robot has not answered for 5 s")
    assert len(stage.sent()) == 1


def test_a_drive_that_somebody_stopped_pauses_before_it_goes_on() -> None:
    stage = Stage(APPROACH, TeleportRobot(delay=100.0))
    stage.run(None)
    stage.robot.stop()
    assert stage.run(None, 1.0) is Status.FAILURE
    assert stage.message("MoveBase").endswith("cancelled: stopped")
    assert len(stage.sent(CommandKind.GO_TO)) == 1


class LostRobot(TeleportRobot):
    lost = True

    @property
    def pose(self) -> Pose2D:
        if self.lost:
            raise RobotError("no pose has been heard yet")
        return self.place


def test_a_robot_that_does_not_know_where_it_stands() -> None:
    robot = LostRobot()
    context = TickContext(0.0, Phase.IA, PersonFrame(0.0, head=(4.0, 1.0, 1.7)), robot)
    tree = one_tree(APPROACH)
    assert tree.tick(context) is Status.FAILURE
    robot.lost = False
    assert tree.tick(context) is Status.RUNNING
    robot.lost = True
    assert tree.tick(context) is Status.FAILURE
    assert "no pose has been heard yet" in {state.message for state in tree.states()}
    assert robot.log[0].status is CommandStatus.CANCELLED


def test_an_unknown_heading_keeps_to_the_line() -> None:
    stage = Stage(APPROACH)
    stage.face, stage.rotation = (4.0, 0.0, 1.7), UNKNOWN_ROTATION
    stage.run(None)
    assert close(stage.sent()[0].asked["goal"], Pose2D(3, 0, 0))


def test_the_robot_does_not_back_away_unless_told_to() -> None:
    for retreat, wanted in (("false", 0), ("true", 1)):
        stage = Stage(APPROACH.replace("goal_pose", f'retreat="{retreat}" goal_pose', 1))
        stage.face, stage.rotation = (0.5, 0.0, 1.7), yaw_quaternion(math.pi)
        stage.run(None)
        assert len(stage.sent()) == wanted


# ---- what a robot must have


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ('<ArmRoutines gesture="ANGRY"/>', "no gesture 'ANGRY'; it has home, wave, handshake"),
        ('<ArmRoutines gesture="10"/>', "no gesture '10'; it has home, wave, handshake"),
        ('<Express expression="smyle"/>', "no expression 'smyle'; it has neutral, smile"),
    ],
)
def test_a_tree_that_names_what_the_robot_has_not_is_refused_before_it_is_ticked(
    body: str, reason: str
) -> None:
    tree = one_tree(f"<Sequence>{body}</Sequence>")
    with pytest.raises(TreeError, match=f"tree 'Main', node .*: the robot has {reason}"):
        Flow(PointRobot(), tree=tree)


def test_a_robot_does_without_a_face_and_names_on_the_blackboard_show_in_ticking() -> None:
    plain = PointRobot()
    plain.expressions = ("neutral",)
    one_tree('<Sequence><Express expression="smile"/></Sequence>').require(plain)
    one_tree('<Sequence><ArmRoutines gesture="{g}"/></Sequence>').require(plain)
    GreetingTree().require(plain)
