"""`kendon ros1`: the greeting as a ROS 1 node."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

from kendon.cli.options import note, out
from kendon.cli.robot_lines import RobotLines
from kendon.errors import UnknownNameError
from kendon.models import load_model
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.environment import ros_module
from kendon.ros.ros1.node import GreetingNode
from kendon.ros.ros1.record import BagRecorder
from kendon.ros.ros1.vizzy import Vizzy
from kendon.ros.settings import Input, NodeSettings, Part, StateType
from kendon.ros.stopping import Stopping
from kendon.sources.ros_place import RobotPlace
from kendon.trees import GreetingTree

EPILOG = """
**Examples**

`kendon ros1` · reads /faces, tells /state, and answers with Vizzy's base, head, arms and voice

`kendon ros1 --part reading --input people` · only tells the phases of whoever is on /people

`kendon ros1 --input humans --record hall.bag` · ROS4HRI's people; recorded, for `kendon estimate`

`kendon ros1 /faces:=/camera/faces __ns:=/vizzy _model:=data-driven` · as ROS remaps it

Every option is also a private parameter of the node (`_robot_face:=0,0,1.3`); an option counts
more.
"""

#: How long the robot's servers are waited for at the start [s].
_CONNECTS = 3.0


def ros1_command(
    remappings: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME:=VALUE]...", help="ROS's remappings and parameters."),
    ] = None,
    part: Annotated[Part | None, typer.Option(help="What the node does; both.")] = None,
    people: Annotated[
        Input | None, typer.Option("--input", help="How people are told of; faces.")
    ] = None,
    state_type: Annotated[StateType | None, typer.Option(help="Of /state; string.")] = None,
    model: Annotated[str | None, typer.Option(help="A model's name or file.")] = None,
    tree: Annotated[
        Path | None, typer.Option(help="A BehaviorTree.CPP XML file instead of kendon's own.")
    ] = None,
    robot_face: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="In the robot's base frame [m]; 0,0,1.2.")
    ] = None,
    base_frame: Annotated[
        str | None, typer.Option(help="The robot's base; base_footprint or base_link.")
    ] = None,
    person: Annotated[str | None, typer.Option(help="Follow the face with this id.")] = None,
    face_height: Annotated[
        float | None, typer.Option(help="Of people whose poses lie on the ground [m].")
    ] = None,
    patience: Annotated[
        float | None, typer.Option(help="How long the robot may be silent [s]; 5.")
    ] = None,
    record: Annotated[
        Path | None, typer.Option(help="Record all that is heard and told into this .bag.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print no phases.")] = False,
) -> None:
    """Read the phases of whoever is on /faces, tell them on /state, and let Vizzy answer."""
    given = {
        "part": part, "input": people, "state_type": state_type, "model": model, "tree": tree,
        "robot_face": robot_face, "base_frame": base_frame, "person": person,
        "face_height": face_height, "patience": patience,
    }  # fmt: skip
    chosen = {name: value for name, value in given.items() if value is not None}
    _check(NodeSettings().with_values(chosen), remappings or [])
    recorder = BagRecorder(record) if record else None
    try:
        start_node("kendon", remappings or [])
        settings = NodeSettings().with_values(_parameters() | chosen)
        place = RobotPlace(settings.base_frame or None)
        robot = Vizzy(place, face=settings.robot_face, patience=settings.patience)
        node = GreetingNode(robot, place, settings, note, recorder)
        if settings.part is not Part.READING and (missing := robot.missing(_CONNECTS)):
            note(f"Nobody answers yet for {', '.join(missing)}; their commands fail until then.")
        _run(node, quiet=quiet)
    finally:
        if recorder is not None:
            recorder.close()
    if record and record.exists():
        out.print(f"All that was heard and told is in {record}.", highlight=False)


def _check(settings: NodeSettings, remappings: list[str]) -> None:
    """Tell a mistake before a master is looked for.

    Raises:
        KendonError: a private parameter is none of the node's, or the model or the tree cannot be
            read.
    """
    names = [field.name for field in fields(NodeSettings)]
    for given in remappings:
        name = given.partition(":=")[0]
        if name.startswith("_") and not name.startswith("__") and name[1:] not in names:
            raise UnknownNameError("parameter of the node", name[1:], names)
    load_model(settings.model)
    if settings.tree:
        GreetingTree(Path(settings.tree))


def _run(node: GreetingNode, *, quiet: bool) -> None:
    """Run the node until a signal, and tell what it does."""
    lines, before = RobotLines(), None
    with Stopping(node.stop):  # the robot stops first
        try:
            for told in node.run():
                if quiet:
                    continue
                phase = told.moment.belief.phase if told.moment.belief else None
                if phase is not before and phase is not None:
                    lines.begin()
                    out.print(f"{phase.name:<4}{phase.title}", highlight=False)
                before = phase
                lines.show(told.moment.commands)
            note("stopped")
        except KeyboardInterrupt:
            note("stopped at once; the robot may not have heard it")
        finally:
            ros_module("rospy").signal_shutdown("kendon ends")


def _parameters() -> dict[str, Any]:
    """The node's private parameters that are settings."""
    rospy = ros_module("rospy")
    names = [field.name for field in fields(NodeSettings)]
    return {name: rospy.get_param(f"~{name}") for name in names if rospy.has_param(f"~{name}")}
