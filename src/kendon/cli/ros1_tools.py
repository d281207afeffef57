"""`kendon ros1-faces` and `kendon gazebo`: people for a ROS 1 robot, of any source, or walking."""

from __future__ import annotations

import time
from typing import Annotated

import typer

from kendon.cli.options import (
    CameraPoseOption,
    FovOption,
    ModelFilesOption,
    PoseModelOption,
    RobotFaceOption,
    note,
    out,
    point,
    source_options,
)
from kendon.errors import ParameterError
from kendon.geometry import Pose2D
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.environment import ros_module
from kendon.ros.ros1.faces import FacePublisher
from kendon.ros.ros1.gazebo import MODEL, SERVICE, GazeboPerson, stations
from kendon.ros.ros1.vizzy import follow_robot
from kendon.ros.watching import Watcher
from kendon.simulation.scripts import WALKING_SPEED
from kendon.sources import open_source
from kendon.sources.ros_place import RobotPlace

FACES_EPILOG = """
**Examples**

`kendon ros1-faces camera:0 --camera-pose 0.1,0,1.3` · whoever stands before the robot's camera

`kendon ros1-faces simulated` · a simulated person, who walks up to where the robot is

`kendon ros1-faces recording.csv faces:=/camera/faces` · a recorded person, in real time
"""
GAZEBO_EPILOG = """
**Examples**

`kendon gazebo 6,0 1,0` · the thesis's person walks up to the origin (Algorithm 2)

`kendon gazebo 6,2 1.5,0 --speed 0.8 --model actor1` · slower, and another model
"""
#: How long a reader of the faces is waited for [s].
_READERS = 5.0


def ros1_faces_command(
    spec: Annotated[str, typer.Argument(metavar="SOURCE", help="See `kendon sources`.")],
    remappings: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME:=VALUE]...", help="ROS's remappings.")
    ] = None,
    robot_face: RobotFaceOption = "0,0,1.2",
    camera_pose: CameraPoseOption = "0,0,1.2",
    fov: FovOption = None,
    model_files: ModelFilesOption = None,
    pose_model: PoseModelOption = None,
) -> None:
    """Tell a ROS 1 robot of the person of a source, on /faces, as they move."""
    options = source_options(camera_pose, fov, None, model_files, None, pose_model)
    face = point("--robot-face", robot_face)
    source = open_source(spec, options)
    start_node("kendon_faces", remappings or [])
    place = RobotPlace()
    follow_robot(place)
    faces = FacePublisher()
    if not faces.awaited(_READERS):
        note(f"Nobody reads {faces.topic} yet.")
    source.attach(Watcher(place, face))
    for sentence in source.notes:
        note(sentence)
    begin = time.monotonic()
    count = 0
    try:
        for frame in source.frames():
            if not source.live:
                time.sleep(max(0.0, begin + frame.t - time.monotonic()))
            faces.tell(frame)
            count += 1
    except KeyboardInterrupt:
        note("stopped")
    finally:
        faces.close()
        ros_module("rospy").signal_shutdown("kendon ends")
    out.print(f"{count} faces were told on {faces.topic}.", highlight=False)


def gazebo_command(
    start: Annotated[str, typer.Argument(metavar="X,Y", help="Where the walk begins [m].")],
    goal: Annotated[str, typer.Argument(metavar="X,Y", help="Where it ends [m].")],
    remappings: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME:=VALUE]...", help="ROS's remappings.")
    ] = None,
    speed: Annotated[float, typer.Option(help="Of the walk [m/s].")] = WALKING_SPEED,
    model: Annotated[str, typer.Option(help="The person's model in Gazebo.")] = MODEL,
    service: Annotated[str, typer.Option(help="What moves models.")] = SERVICE,
) -> None:
    """Let a model of a person walk in Gazebo (thesis Algorithm 2)."""
    walk = _place("the start", start), _place("the goal", goal)
    stations(*walk, speed)  # a mistake is told before a master is looked for
    start_node("kendon_gazebo", remappings or [])
    try:
        count = sum(1 for _ in GazeboPerson(model, service).walk(*walk, speed))
    finally:
        ros_module("rospy").signal_shutdown("kendon ends")
    out.print(f"{model} has walked {walk[0].distance_to(walk[1]):.1f} m in {count} stations.")


def _place(what: str, text: str) -> Pose2D:
    try:
        x, y = (float(part) for part in text.split(","))
        return Pose2D(x, y, 0.0)
    except ValueError:
        raise ParameterError(f"{what} of the walk is X,Y in metres, not {text!r}") from None
