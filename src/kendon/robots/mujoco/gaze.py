"""How a joint must turn so that a line of sight passes through a point: closed forms.

In the plane across its axis, a joint swings the line of sight around; the line keeps its distance
b from the axis, so it meets a point r away from the axis, in the direction phi, when it points
along phi - asin(b / r). A head pans first and then tilts in the plane that the pan has chosen.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from kendon.geometry import wrap_angle
from kendon.person import FloatArray


class Pointer:
    """A hinge that turns a line of sight, in the frame its body hangs in.

    Args:
        model: the robot.
        data: its state with this joint (and those between it and the sight) at zero and
            kinematics computed.
        joint: the joint's index.
        sight: the site's (or body's) position and rotation matrix in the world; its x axis is
            the line of sight.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        joint: int,
        sight: tuple[FloatArray, FloatArray],
    ) -> None:
        body = int(model.jnt_bodyid[joint])
        self.parent = int(model.body_parentid[body])
        self.address = int(model.jnt_qposadr[joint])
        place, turn = data.xpos[self.parent], data.xmat[self.parent].reshape(3, 3)
        self.anchor: FloatArray = turn.T @ (data.xanchor[joint] - place)
        self.axis: FloatArray = turn.T @ data.xaxis[joint]
        direction = turn.T @ sight[1].reshape(3, 3)[:, 0]
        #: How far the sight is from lying in the plane across the axis [1].
        self.lean = float(direction @ self.axis)
        ahead = direction - self.lean * self.axis
        self.ahead: FloatArray = ahead / np.linalg.norm(ahead)  # where it points at angle zero
        self.across: FloatArray = np.cross(self.axis, self.ahead)  # 90 degrees on
        #: How far the line of sight passes the axis, toward `across` [m].
        self.offset = float((turn.T @ (sight[0] - place) - self.anchor) @ self.across)

    def angle(self, point: FloatArray) -> float:
        """The angle that points the line of sight at a point of the parent's frame [rad].

        A point nearer to the axis than the line of sight ever comes is missed as narrowly as
        can be.
        """
        way = point - self.anchor
        x, y = float(way @ self.ahead), float(way @ self.across)
        r = math.hypot(x, y)
        aside = math.copysign(math.pi / 2, self.offset) if r <= abs(self.offset) else (
            math.asin(self.offset / r)
        )  # fmt: skip
        return wrap_angle(math.atan2(y, x) - aside)

    def unturned(self, point: FloatArray, angle: float) -> FloatArray:
        """Where a point of the parent's frame is for somebody who turns with the joint."""
        way = point - self.anchor
        c, s = math.cos(angle), math.sin(angle)
        along = self.axis * (self.axis @ way)
        turned: FloatArray = c * way - s * np.cross(self.axis, way) + (1 - c) * along
        return self.anchor + turned


class HeadGeometry:
    """Pan and tilt, one after the other.

    Args:
        model: the robot.
        data: its state with all joints at zero and kinematics computed.
        pan: the pan joint's index.
        tilt: the tilt joint's.
        sight: the face, see `Pointer`.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        pan: int,
        tilt: int,
        sight: tuple[FloatArray, FloatArray],
    ) -> None:
        self.pan = Pointer(model, data, pan, sight)
        self.tilt = Pointer(model, data, tilt, sight)
        self._parent = self.pan.parent
        here, there = self.pan.parent, self.tilt.parent
        frame = data.xmat[here].reshape(3, 3)
        self._link_place: FloatArray = frame.T @ (data.xpos[there] - data.xpos[here])
        self._link_turn: FloatArray = frame.T @ data.xmat[there].reshape(3, 3)

    @property
    def square(self) -> bool:
        """Whether the closed form holds: the tilt's axis across the pan's and the sight's."""
        axis = self._link_turn @ self.tilt.axis
        return abs(float(axis @ self.pan.axis)) < 1e-3 and abs(self.tilt.lean) < 1e-3

    def angles(self, data: mujoco.MjData, point: FloatArray) -> tuple[float, float]:
        """The joint angles that point the face at a point of the world [rad]."""
        local = data.xmat[self._parent].reshape(3, 3).T @ (point - data.xpos[self._parent])
        pan = self.pan.angle(local)
        within = self._link_turn.T @ (self.pan.unturned(local, pan) - self._link_place)
        return pan, self.tilt.angle(within)


def local_point(data: mujoco.MjData, body: int, point: FloatArray) -> FloatArray:
    """A point of the world in a body's frame [m]."""
    local: FloatArray = data.xmat[body].reshape(3, 3).T @ (point - data.xpos[body])
    return local
