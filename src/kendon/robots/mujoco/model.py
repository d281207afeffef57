"""A robot's model as MuJoCo runs it: the file of its mapping, given servos and a base that drives.

The base is a planar joint that two velocity servos move forward and around, while a third holds
it against sliding sideways, as wheels do. Every other joint has a servo of its own. Nothing
collides: the base keeps away from people by itself (`kendon.robots.clearance`), and contacts would
only cost time.
"""

from __future__ import annotations

from importlib.resources import as_file
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco

from kendon.errors import DataError, UnknownNameError
from kendon.robots.mujoco.description import RobotDescription

#: A physics step [s].
STEP = 0.005

_BASE_JOINTS = ("kendon_x", "kendon_y", "kendon_yaw")
_BASE_SITE = "kendon_base"


def read_model(description: RobotDescription) -> tuple[Any, dict[str, float]]:
    """The model's file as a spec, with the base free to drive, and a URDF's joint speeds.

    Raises:
        DataError: it cannot be read, or has no such body as its base.
    """
    speeds: dict[str, float] = {}
    with as_file(description.model) as path:
        try:
            if path.suffix.lower() == ".urdf":
                text, speeds = _urdf(path)
                spec = mujoco.MjSpec.from_string(text)
                spec.modelfiledir = str(path.parent)
            else:
                spec = mujoco.MjSpec.from_file(str(path))
        except (ValueError, OSError, ElementTree.ParseError) as error:
            why = "there is no such file" if not path.exists() else " ".join(str(error).split())
            raise DataError(
                f"the model {path.name} cannot be read: {why}", file=str(description.file)
            ) from None
    base = spec.body(description.base)
    roots = [body.name for body in spec.worldbody.bodies]
    if base is None or base.name not in roots:
        raise description.error(
            f"base.body: {UnknownNameError('root body', description.base, roots)}"
        )
    for joint in list(base.joints):
        spec.delete(joint)
    _drive(spec, base)
    return spec, speeds


def _urdf(path: Path) -> tuple[str, dict[str, float]]:
    """A URDF's text, told to keep its links and shapes, and its joints' speeds [rad/s or m/s]."""
    root = ElementTree.parse(path).getroot()
    extension = root.find("mujoco")
    if extension is None:
        extension = ElementTree.SubElement(root, "mujoco")
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = ElementTree.SubElement(extension, "compiler")
    for key in ("fusestatic", "discardvisual"):
        compiler.attrib.setdefault(key, "false")
    speeds = {
        joint.attrib["name"]: float(limit.attrib["velocity"])
        for joint in root.iter("joint")
        if (limit := joint.find("limit")) is not None and float(limit.get("velocity", 0)) > 0
    }
    return ElementTree.tostring(root, encoding="unicode"), speeds


def _drive(spec: Any, base: Any) -> None:
    """Let the base move over the floor, pushed forward and around, held sideways."""
    kinds = (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE)
    axes = ([1, 0, 0], [0, 1, 0], [0, 0, 1])
    for name, kind, axis in zip(_BASE_JOINTS, kinds, axes, strict=True):
        base.add_joint(name=name, type=kind, axis=axis)
    base.add_site(name=_BASE_SITE)
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for name, gear in (
        ("kendon_forward", [1, 0, 0, 0, 0, 0]),
        ("kendon_turn", [0, 0, 0, 0, 0, 1]),
        ("kendon_sideways", [0, 1, 0, 0, 0, 0]),
    ):
        servo = _speed_servo(spec, name)
        servo.trntype = mujoco.mjtTrn.mjTRN_SITE
        servo.target = _BASE_SITE
        servo.gear = gear


def _speed_servo(spec: Any, name: str) -> Any:
    servo = spec.add_actuator(name=name)
    servo.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    return servo


def compile_model(description: RobotDescription, spec: Any) -> Any:
    """Give the joints servos and compile; the stiffness is set later.

    Raises:
        DataError: a joint is of a kind, or without a name, that cannot be driven.
    """
    wheels = description.wheels
    wheel_names = () if wheels is None else (wheels.left, wheels.right)
    for joint in spec.joints:
        if joint.name in _BASE_JOINTS:
            continue
        if joint.type not in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            raise description.error(
                f"the joint {joint.name!r} neither turns about one axis nor slides along one"
            )
        if not joint.name:
            raise description.error("a joint of the model has no name; name them all")
        servo = _speed_servo(spec, joint.name)
        servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
        servo.target = joint.name
        if joint.name not in wheel_names:
            servo.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
    option = spec.option
    option.timestep = STEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # The motors' own controllers hold the joints against gravity, and the base cannot tip.
    option.gravity = [0, 0, 0]
    # Set-points keep the joints in their ranges, so that nothing needs MuJoCo's solver.
    for flag in (mujoco.mjtDisableBit.mjDSBL_CONTACT, mujoco.mjtDisableBit.mjDSBL_LIMIT):
        option.disableflags |= int(flag)
    try:
        return spec.compile()
    except ValueError as error:
        why = " ".join(str(error).split())
        raise description.error(f"the model {description.model.name} is not right: {why}") from None
