"""The robots that can be asked for by name, and how each of them is made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from kendon.errors import DataError, ParameterError, UnknownNameError
from kendon.geometry import Vec3
from kendon.robots.base import Robot
from kendon.robots.point import PointRobot

#: The robot that greets where nobody asks for another.
DEFAULT_ROBOT = "point"


@dataclass(frozen=True, slots=True)
class RobotOptions:
    """What a user may say about a robot."""

    face: Vec3 | None = None  # [m] in its base frame, for a robot without a body of its own
    leash: float | None = None  # [m], how far its base may get from its start; None is free


@dataclass(frozen=True, slots=True)
class RobotKind:
    """An entry of the register."""

    name: str
    what: str  # one line for `kendon robots`
    make: Callable[[RobotOptions], Robot]


def robot_kinds() -> dict[str, RobotKind]:
    """All robots by name."""
    return dict(_REGISTER)


def make_robot(spec: str, options: RobotOptions | None = None) -> Robot:
    """The robot of a name, or of a robot file (a mapping, see `kendon.robots.mujoco`).

    Raises:
        UnknownNameError: no robot has that name.
        DataError: the robot file is missing or wrong.
        ParameterError: an option does not suit the robot.
    """
    options = options or RobotOptions()
    if spec in _REGISTER:
        return _REGISTER[spec].make(options)
    if Path(spec).suffix.lower() == ".toml":
        return _with_body(options, spec)
    if Path(spec).is_file():
        raise DataError(
            "a robot is described by a .toml file that names its MJCF or URDF model", file=spec
        )
    raise UnknownNameError("robot", spec, [*_REGISTER, "or a path to a .toml robot file"])


def _point(options: RobotOptions) -> Robot:
    if options.face is None:
        return PointRobot(leash=options.leash)
    return PointRobot(face=options.face, leash=options.leash)


def _with_body(options: RobotOptions, file: str | None = None) -> Robot:
    if options.face is not None:
        raise ParameterError(
            "the place of the face can only be given for the robot 'point'; others have their own"
        )
    # MuJoCo takes a moment to import: only those who ask for a body wait for it.
    from kendon.robots.mujoco import MujocoRobot, read_description

    return MujocoRobot(
        description=None if file is None else read_description(file), leash=options.leash
    )


_REGISTER: dict[str, RobotKind] = {
    kind.name: kind
    for kind in (
        RobotKind("point", "ideal kinematics and no body; the fastest", _point),
        RobotKind("mujoco", "Vizzy's body with physics, for pictures and films", _with_body),
    )
}
