"""The robot as the page draws it: its own body where it has one, else a plain one."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from kendon.geometry import Vec3
from kendon.person import FloatArray
from kendon.robots import CommandKind, PointRobot, Robot
from kendon.viewer.browser.forms import Color, Float32Array, Pieces

if TYPE_CHECKING:  # half a second: not for those who need none
    from scipy.spatial.transform import Rotation

_SHELL: Color = (237, 237, 230)
_ACCENT: Color = (26, 135, 140)
_FRAME: Color = (97, 105, 112)
_DARK: Color = (36, 38, 43)
_LIPS: Color = (158, 51, 56)

#: The plain body's arms at rest and in its gestures [rad]: raised forward, raised sideways, bent.
_REST = (0.0, 0.12, 0.25)
_RIGHT = {"wave": (0.35, 2.15, 0.75), "handshake": (0.75, 0.0, 0.75), "stretch": (0.0, 1.5, 0.1)}
_LEFT = {"stretch": (0.0, 1.5, 0.1)}
#: How fast a plain arm's joints turn [rad/s], and how often it waves and shakes [1/s].
_FASTEST, _STROKES = 5.0, 1.5


class RobotForm(ABC):
    """Turns a robot's state into a body."""

    @abstractmethod
    def state(self, robot: Robot) -> Float32Array:
        """All that `draw` needs to know of the robot now; its first numbers x, y, yaw."""

    @abstractmethod
    def draw(self, state: Float32Array) -> tuple[Pieces, Vec3, tuple[float, float, float, float]]:
        """The body, where its face is, and the face's rotation w x y z (x looks)."""

    def between(self, a: Float32Array, b: Float32Array, share: float) -> Float32Array:
        """A state on the way from one to a later one."""
        way = b - a
        way[2] = (way[2] + math.pi) % (2 * math.pi) - math.pi
        state: Float32Array = a + np.float32(share) * way
        return state


def robot_form(robot: Robot) -> RobotForm:
    """The body that suits a robot."""
    if isinstance(robot, PointRobot):
        return PlainForm(robot.face)
    # A robot with a body of its own has imported MuJoCo already.
    from kendon.viewer.browser.mujoco_form import MujocoForm, has_body

    return MujocoForm(robot) if has_body(robot) else PlainForm(robot.face)


class PlainForm(RobotForm):
    """A body for robots that have none: a base, a trunk, two arms, a head that turns and smiles.

    Args:
        face: the robot's face in its base frame [m].
    """

    def __init__(self, face: Vec3) -> None:
        self._face = face
        self._arms: FloatArray = np.array([*_REST, *_REST])  # the right one, the left one
        self._time = 0.0  # [s], the robot's clock when they were there

    def state(self, robot: Robot) -> Float32Array:
        """X y yaw, pan, tilt, smile, and three angles of the right and the left arm."""
        head = (robot.pan, robot.tilt) if isinstance(robot, PointRobot) else (0.0, 0.0)
        smile = 0.0
        if isinstance(robot, PointRobot) and robot.expression[0] == "smile":
            smile = robot.expression[1]
        self._move_arms(robot)
        return np.array([*robot.pose, *head, smile, *self._arms], dtype=np.float32)

    def _move_arms(self, robot: Robot) -> None:
        """Bring the arms nearer to where the running gesture has them."""
        command = robot.running(CommandKind.GESTURE)
        right, left = np.array(_REST), np.array(_REST)
        if command is not None:
            name, since = str(command.asked["name"]), robot.time - command.issued
            right, left = np.array(_RIGHT.get(name, _REST)), np.array(_LEFT.get(name, _REST))
            stroke = math.sin(2 * math.pi * _STROKES * since)
            if name == "wave":
                right[2] += 0.4 * stroke
            elif name == "handshake" and since > 1:
                right[0] += 0.1 * stroke
        step = _FASTEST * max(0.0, robot.time - self._time)
        self._time = robot.time
        goal = np.concatenate([right, left])
        self._arms += np.clip(goal - self._arms, -step, step)

    def draw(self, state: Float32Array) -> tuple[Pieces, Vec3, tuple[float, float, float, float]]:
        """See `RobotForm`."""
        from scipy.spatial.transform import Rotation

        x, y, yaw, pan, tilt, smile, *arms = state.astype(float).tolist()
        height = self._face[2]
        size = height / 1.2
        turn = Rotation.from_euler("z", yaw)
        origin = np.array([x, y, 0.0])

        def at(*point: float) -> FloatArray:
            place: FloatArray = origin + turn.apply(np.array(point) * size)
            return place

        upright = wxyz(turn)
        pieces = Pieces()
        pieces.rod(at(0, 0, 0.09), upright, 0.25 * size, 0.12 * size, _FRAME)
        pieces.ball(at(0, 0, 0.16), (0.25 * size, 0.25 * size, 0.07 * size), _SHELL, upright)
        for side in (0.25, -0.25):
            across = wxyz(turn * Rotation.from_euler("x", math.pi / 2))
            pieces.rod(at(0, side, 0.11), across, 0.11 * size, 0.04 * size, _DARK)
        pieces.capsule(at(0, 0, 0.2), at(0, 0, 0.62), 0.07 * size, _FRAME)
        pieces.ball(at(0, 0, 0.80), (0.14 * size, 0.17 * size, 0.24 * size), _SHELL, upright)
        pieces.ball(at(0.125, 0, 0.84), (0.03 * size, 0.06 * size, 0.07 * size), _ACCENT, upright)
        pieces.capsule(at(0, 0, 1.0), at(0, 0, 1.1), 0.04 * size, _FRAME)
        for side, angles in ((-1.0, arms[:3]), (1.0, arms[3:])):
            self._arm(pieces, at, side, angles, size)
        look = turn * Rotation.from_euler("zy", [pan, -tilt])
        face = origin + turn.apply(self._face)
        self._head(pieces, face, look, smile, size)
        return pieces, (face[0], face[1], face[2]), wxyz(look)

    @staticmethod
    def _arm(pieces: Pieces, at: Any, side: float, angles: Iterable[float], size: float) -> None:
        from scipy.spatial.transform import Rotation

        forward, sideways, bent = angles
        shoulder = np.array([0.0, side * 0.2, 0.95])
        lift = Rotation.from_euler("xy", [side * sideways, -forward])
        elbow = shoulder + lift.apply([0.0, 0.0, -0.26])
        # A raised arm bends its forearm up, a hanging one forward.
        raised = min(1.0, sideways / 1.5)
        fold = Rotation.from_euler("y", -bent * (1 - raised)) * Rotation.from_euler(
            "x", side * bent * raised
        )
        hand = elbow + (lift * fold).apply([0.0, 0.0, -0.24])
        pieces.capsule(at(*shoulder), at(*elbow), 0.045 * size, _ACCENT)
        pieces.capsule(at(*elbow), at(*hand), 0.038 * size, _SHELL)
        pieces.ball(at(*hand), (0.055 * size,) * 3, _DARK)

    @staticmethod
    def _head(pieces: Pieces, face: FloatArray, look: Rotation, smile: float, size: float) -> None:
        def at(*point: float) -> FloatArray:
            place: FloatArray = face + look.apply(np.array(point) * size)
            return place

        turn = wxyz(look)
        pieces.ball(at(-0.10, 0, 0.02), (0.13 * size, 0.14 * size, 0.15 * size), _SHELL, turn)
        for side in (0.055, -0.055):
            pieces.ball(
                at(0.005, side, 0.05), (0.02 * size, 0.026 * size, 0.03 * size), _DARK, turn
            )
        for side in (1.0, -1.0):
            corner = at(0.0, side * 0.05, -0.055 + 0.035 * smile)
            pieces.capsule(at(0.018, 0, -0.065), corner, 0.008 * size, _LIPS)


def wxyz(turn: Rotation) -> tuple[float, float, float, float]:
    """A rotation as w x y z."""
    x, y, z, w = turn.as_quat().tolist()
    return (w, x, y, z)
