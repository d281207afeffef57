"""How a joint must turn so that a line of sight passes through a point: closed forms.

In the plane across its axis, a joint swings the line of sight around; the line keeps its distance
b from the axis, so it meets a point r away from the axis, in the direction phi, when it points
along phi - asin(b / r). A head pans first and then tilts in the plane that the pan has chosen.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kendon.geometry import Vec3, wrap_angle
from kendon.person import FloatArray

#: A rotation matrix, row by row. What runs in every control cycle is plain Python: with three
#: numbers at a time, arrays cost ten times as much.
Matrix = tuple[Vec3, Vec3, Vec3]


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
        self, model: Any, data: Any, joint: int, sight: tuple[FloatArray, FloatArray]
    ) -> None:
        self.parent = int(model.body_parentid[model.jnt_bodyid[joint]])
        place, turn = data.xpos[self.parent], data.xmat[self.parent].reshape(3, 3)
        anchor = turn.T @ (data.xanchor[joint] - place)
        axis = turn.T @ data.xaxis[joint]
        direction = turn.T @ sight[1].reshape(3, 3)[:, 0]
        #: How far the sight is from lying in the plane across the axis [1].
        self.lean = float(direction @ axis)
        ahead = direction - self.lean * axis
        ahead = ahead / max(1e-9, float(np.linalg.norm(ahead)))
        across = np.cross(axis, ahead)
        self.anchor, self.axis = _vector(anchor), _vector(axis)
        self.ahead = _vector(ahead)  # where it points at angle zero
        self.across = _vector(across)  # 90 degrees on
        #: How far the line of sight passes the axis, toward `across` [m].
        self.offset = float((turn.T @ (sight[0] - place) - anchor) @ across)

    @property
    def blind(self) -> bool:
        """Whether the joint turns about the line of sight and so does not turn it at all."""
        return abs(self.lean) > 0.99

    def angle(self, point: Vec3) -> float:
        """The angle that points the line of sight at a point of the parent's frame [rad].

        A point nearer to the axis than the line of sight ever comes is missed as narrowly as
        can be.
        """
        way = _minus(point, self.anchor)
        x, y = _dot(way, self.ahead), _dot(way, self.across)
        r = math.hypot(x, y)
        if r <= abs(self.offset):
            aside = math.copysign(math.pi / 2, self.offset)
        else:
            aside = math.asin(self.offset / r)
        return wrap_angle(math.atan2(y, x) - aside)

    def unturned(self, point: Vec3, angle: float) -> Vec3:
        """Where a point of the parent's frame is for somebody who turns with the joint."""
        way = _minus(point, self.anchor)
        c, s = math.cos(angle), math.sin(angle)
        x, y, up = _dot(way, self.ahead), _dot(way, self.across), _dot(way, self.axis)
        x, y = c * x + s * y, c * y - s * x
        px, py, pz = (
            a + x * e + y * n + up * z
            for a, e, n, z in zip(self.anchor, self.ahead, self.across, self.axis, strict=True)
        )
        return (px, py, pz)


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
        self, model: Any, data: Any, pan: int, tilt: int, sight: tuple[FloatArray, FloatArray]
    ) -> None:
        self.pan = Pointer(model, data, pan, sight)
        self.tilt = Pointer(model, data, tilt, sight)
        here, there = self.pan.parent, self.tilt.parent
        frame = data.xmat[here].reshape(3, 3)
        self._link_place = _vector(frame.T @ (data.xpos[there] - data.xpos[here]))
        turn = frame.T @ data.xmat[there].reshape(3, 3)
        self._link_turn = _matrix(turn)
        axis = turn @ np.array(self.tilt.axis)
        #: Whether the closed form holds: the tilt's axis across the pan's and the sight's.
        self.square = (
            abs(float(axis @ self.pan.axis)) < 1e-3
            and abs(self.tilt.lean) < 1e-3
            and not self.pan.blind
        )

    def angles(self, data: Any, point: Vec3) -> tuple[float, float]:
        """The joint angles that point the face at a point of the world [rad]."""
        local = local_point(data, self.pan.parent, point)
        pan = self.pan.angle(local)
        within = _transposed(
            self._link_turn, _minus(self.pan.unturned(local, pan), self._link_place)
        )
        return pan, self.tilt.angle(within)


def local_point(data: Any, body: int, point: Vec3) -> Vec3:
    """A point of the world in a body's frame [m]."""
    a, b, c, d, e, f, g, h, i = data.xmat[body].tolist()
    return _transposed(((a, b, c), (d, e, f), (g, h, i)), _minus(point, data.xpos[body].tolist()))


def _transposed(turn: Matrix, v: Vec3) -> Vec3:
    """The vector turned back."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    x, y, z = v
    return (a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z)


def _dot(a: Vec3, b: Vec3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _minus(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _vector(v: FloatArray) -> Vec3:
    x, y, z = v.tolist()
    return (x, y, z)


def _matrix(m: FloatArray) -> Matrix:
    return (_vector(m[0]), _vector(m[1]), _vector(m[2]))
