"""Robots with a body in MuJoCo: kendon's Vizzy, or any MJCF or URDF with a mapping file."""

import os

from kendon.errors import RendererError

try:
    import mujoco as _mujoco  # noqa: F401
except (AttributeError, ImportError, RuntimeError) as error:
    # MuJoCo looks for what MUJOCO_GL names as soon as it is imported, before anything is drawn.
    _named = os.environ.get("MUJOCO_GL")
    if not _named:
        raise
    raise RendererError(
        f"MuJoCo cannot start with MUJOCO_GL={_named} ({' '.join(str(error).split())}); unset it,"
        " or install what it names (on Debian: apt-get install libegl1 libopengl0"
        " libgl1-mesa-dri, or libosmesa6)"
    ) from None

from kendon.robots.mujoco.description import RobotDescription, read_description
from kendon.robots.mujoco.robot import MujocoRobot

__all__ = ["MujocoRobot", "RobotDescription", "read_description"]
