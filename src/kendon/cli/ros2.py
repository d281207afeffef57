"""`kendon ros2`: a node of ROS 2 that needs no ROS."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from kendon.cli.options import (
    CameraPoseOption,
    ModelOption,
    RobotFaceOption,
    err,
    note,
    out,
    point,
    source_options,
)
from kendon.cli.robot_lines import RobotLines
from kendon.errors import DataError, ParameterError
from kendon.models import DEFAULT_MODEL, load_model
from kendon.phases import Phase
from kendon.ros.dds import DOMAINS, DdsNode
from kendon.ros.ros2_names import remappings
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_reading import Engagement, Told
from kendon.ros.ros2_record import Recorder
from kendon.ros.ros2_robot import Ros2Robot
from kendon.ros.ros2_settings import Drive, Ros2Settings, check_lateness
from kendon.ros.stopping import Stopping
from kendon.sources.bag_people import BagOptions
from kendon.sources.live_people import PATIENCE
from kendon.trees import GreetingTree

EPILOG = """
**Examples**

`kendon ros2 --domain 7` · phases and engagement of all ROS4HRI people on this domain

`kendon ros2 --robot goal_pose` · and let a robot with Nav2 greet them

`kendon ros2 --robot cmd_vel --robot-face 0.1,0,1.1 --record greeting.mcap` · ros2_control; recorded

`kendon ros2 --robot goal_pose /odom:=/my_robot/odom /goal_pose:=/my_robot/goal` · other names
"""
#: Whoever waits for nobody is told so after this [s].
_SPEAKS_AFTER = 3.0


def ros2_command(
    topics: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME:=OTHER]...", help="Topics with another name, as in ROS."),
    ] = None,
    domain: Annotated[
        int, typer.Option(envvar="ROS_DOMAIN_ID", help="DDS's number of the network of nodes.")
    ] = 0,
    robot: Annotated[
        Drive | None,
        typer.Option(
            help="Let a robot greet: goal_pose is for Nav2, cmd_vel for ros2_control and its kin."
        ),
    ] = None,
    model: ModelOption = DEFAULT_MODEL,
    tree: Annotated[
        Path | None, typer.Option(help="A BehaviorTree.CPP XML file instead of kendon's own.")
    ] = None,
    record: Annotated[
        Path | None, typer.Option(help="Record all that is heard and told into this .mcap.")
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(help="End after so many seconds; until Ctrl-C if not given.")
    ] = None,
    base: Annotated[
        str | None, typer.Option(help="The robot's base frame, if it is not base_footprint.")
    ] = None,
    world: Annotated[
        str, typer.Option(help="The frame that goals are given in, if not that of /tf or /odom.")
    ] = "",
    leash: Annotated[
        float | None, typer.Option(help="Drive no farther than this from the start [m].")
    ] = None,
    lateness: Annotated[
        float, typer.Option(help="So late messages may be to count [s], as over a slow network.")
    ] = PATIENCE,
    robot_face: RobotFaceOption = "0,0,1.2",
    camera_pose: CameraPoseOption = "0,0,1.2",
) -> None:
    """Be a node of ROS 2, without ROS: read people, tell their phases, let a robot greet."""
    if domain not in DOMAINS:
        raise ParameterError(f"--domain lies between 0 and {DOMAINS[-1]}, not {domain}")
    if seconds is not None and not 0 < seconds < float("inf"):
        raise ParameterError(f"--seconds is more than 0, not {seconds:g}")
    check_lateness("--lateness", lateness)
    for option, given in (("--tree", tree), ("--leash", leash), ("--world", world or None)):
        if robot is None and given is not None:
            raise ParameterError(
                f"{option} is for a robot that greets; give --robot"
                f" {' or '.join(drive.value for drive in Drive)}, too"
            )
    face = point("--robot-face", robot_face)
    options = BagOptions(base, source_options(camera_pose, None, None, None).camera)
    greeting_model = load_model(model)
    behaviour = GreetingTree(tree) if tree else GreetingTree()
    settings = None
    if robot is not None:
        settings = Ros2Settings(robot, world=world, face=face, leash=leash)
    transport = DdsNode(domain, remappings(topics or []))
    recorder = Recorder(record) if record else None
    node = Ros2Node(
        transport, greeting_model, options=options, face=face, recorder=recorder, patience=lateness
    )
    with Stopping() as stop:
        try:
            if settings is not None:
                greeter = Ros2Robot(transport, node.place, settings, clock=time.time_ns)
                node.greet_with(greeter, behaviour)
            _run(node, domain, seconds, stop)
        except KeyboardInterrupt:
            err.print("stopped at once", style="dim")
        finally:
            node.close()
    if record and record.exists():
        out.print(f"All that was heard and told is in {record}.", highlight=False)


def _run(node: Ros2Node, domain: int, seconds: float | None, stop: Stopping) -> None:
    began = time.monotonic()
    noted: set[str] = set()
    waiting = ""
    phases: dict[str, Phase] = {}
    lines = RobotLines()
    note(f"on domain {domain}, until {'Ctrl-C' if seconds is None else f'{seconds:g} s are over'}")
    with contextlib.closing(node.run()) as steps:
        for told, moments in steps:
            for one in told:
                if _show(one, phases) and one.name == node.reader.followed:
                    lines.begin()
            lines.show(command for moment in moments for command in moment.commands)
            for sentence in node.notes:
                if sentence not in noted:
                    noted.add(sentence)
                    note(sentence)
            passed = time.monotonic() - began
            if passed > _SPEAKS_AFTER and node.waiting not in ("", waiting):
                waiting = node.waiting
                note(f"waiting: {waiting}")
            if stop.asked:
                err.print("stopped", style="dim")
                break
            if seconds is not None and passed >= seconds:
                break
    if node.late:
        note(f"frames left out as they came too late: {node.late}")
    if seconds is not None and node.waiting:
        raise DataError(node.waiting)


def _show(told: Told, phases: dict[str, Phase]) -> bool:
    """Print a person's phase when it changes, and when they have gone; whether one was."""
    if told.observation is None:
        if phases.pop(told.name, None):
            out.print(f"{told.name}  gone", highlight=False)
        return False
    if told.belief is None or phases.get(told.name) is told.belief.phase:
        return False
    phase = phases[told.name] = told.belief.phase
    level = Engagement(told.engagement).name.lower()
    line = Text(f"{told.name}  ")
    line.append(f"{phase.name}  {phase.title}", style=phase.color)
    out.print(line.append(f"  {level}", style="dim"))
    return True
