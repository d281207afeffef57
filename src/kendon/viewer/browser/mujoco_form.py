"""The body of a robot in MuJoCo as balls and rods, drawn at any of its states."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from kendon.geometry import Vec3
from kendon.robots import Robot
from kendon.robots.mujoco import MujocoRobot
from kendon.viewer.browser.forms import Color, Float32Array, Pieces, rgb
from kendon.viewer.browser.robot_form import RobotForm

_GEOM = mujoco.mjtGeom
#: Boxes and meshes are drawn as the ellipsoids in them.
_ROUND = (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_ELLIPSOID, _GEOM.mjGEOM_BOX, _GEOM.mjGEOM_MESH)


def has_body(robot: Robot) -> bool:
    """Whether a robot's body can be drawn here."""
    return isinstance(robot, MujocoRobot)


class MujocoForm(RobotForm):
    """Draws the robot's own geometry.

    Args:
        robot: a `MujocoRobot`.
    """

    def __init__(self, robot: Robot) -> None:
        assert isinstance(robot, MujocoRobot)
        self._model: Any = robot.body.model
        self._data: Any = mujoco.MjData(self._model)  # the robot's own is left alone
        self._site = robot.description.head.face
        self._on_body = self._site not in robot.body.sites
        model = self._model
        self._geoms = [
            (g, int(model.geom_type[g]), model.geom_size[g].tolist(), self._color(g))
            for g in range(model.ngeom)
            if model.geom_type[g] != _GEOM.mjGEOM_PLANE and model.geom_group[g] < 3
        ]

    def _color(self, geom: int) -> Color:
        material = int(self._model.geom_matid[geom])
        rgba = self._model.mat_rgba[material] if material >= 0 else self._model.geom_rgba[geom]
        return rgb(rgba.tolist())

    def state(self, robot: Robot) -> Float32Array:
        """The positions of all joints, the base's first."""
        assert isinstance(robot, MujocoRobot)
        state: Float32Array = robot.body.data.qpos.astype(np.float32)
        return state

    def draw(self, state: Float32Array) -> tuple[Pieces, Vec3, tuple[float, float, float, float]]:
        """See `RobotForm`."""
        data = self._data
        data.qpos[:] = state
        mujoco.mj_kinematics(self._model, data)
        turns = Rotation.from_matrix(data.geom_xmat.reshape(-1, 3, 3)).as_quat()
        pieces = Pieces()
        for geom, kind, size, color in self._geoms:
            place, (x, y, z, w) = data.geom_xpos[geom], turns[geom].tolist()
            if kind in _ROUND:
                radii = (size[0],) * 3 if kind == _GEOM.mjGEOM_SPHERE else size
                pieces.ball(place.tolist(), radii, color, (w, x, y, z))
            elif kind == _GEOM.mjGEOM_CAPSULE:
                way = data.geom_xmat[geom].reshape(3, 3)[:, 2] * size[1]
                pieces.capsule(place - way, place + way, size[0], color)
            elif kind == _GEOM.mjGEOM_CYLINDER:
                pieces.rod(place.tolist(), (w, x, y, z), size[0], 2 * size[1], color)
        frame = data.body(self._site) if self._on_body else data.site(self._site)
        x, y, z, w = Rotation.from_matrix(frame.xmat.reshape(3, 3)).as_quat().tolist()
        px, py, pz = frame.xpos.tolist()
        return pieces, (px, py, pz), (w, x, y, z)
