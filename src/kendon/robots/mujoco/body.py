"""A robot's body in MuJoCo: its state, its joints by name, and the servos that move them.

Every joint's set-point moves at a limited speed within the joint's range, so that limits hold
whatever is asked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fnmatch import fnmatchcase
from typing import Any

import mujoco
import numpy as np

from kendon.errors import UnknownNameError
from kendon.geometry import Pose2D, Vec3, wrap_angle
from kendon.person import FloatArray
from kendon.robots.mujoco.description import RobotDescription
from kendon.robots.mujoco.gaze import HeadGeometry, Pointer
from kendon.robots.mujoco.model import STEP, compile_model, read_model

#: How many physics steps make a control cycle, and how long that is [s].
STEPS_A_CYCLE = 5
CYCLE = STEP * STEPS_A_CYCLE
#: How quickly a joint's servo answers: the natural frequency of the joint on its spring [rad/s].
#: Chosen: 8 Hz is what geared robot arms of this size reach, and critically damped it follows
#: a gesture 0.04 s late without overshooting.
SERVO_FREQUENCY = 50.0
#: The time constant of the base's and the wheels' speed servos [s].
SPEED_LAG = 0.02


class Body:
    """The compiled model, its state, and its joints by name.

    Args:
        description: the mapping.
        start: where the base stands at first.

    Raises:
        DataError: the model cannot be read, or the mapping does not fit it.
    """

    def __init__(self, description: RobotDescription, start: Pose2D) -> None:
        self.description = description
        spec, velocities = read_model(description)
        self.model: Any = compile_model(description, spec)
        self.data: Any = mujoco.MjData(self.model)
        model = self.model
        names = [model.joint(j).name for j in range(model.njnt)]
        wheels = description.wheels
        wheel_names = () if wheels is None else (wheels.left, wheels.right)
        for name in wheel_names:
            self._require("base.wheels", name, names[3:])
        #: The joints with position servos, in the order of `set_points`.
        self.joints = tuple(n for n in names[3:] if n not in wheel_names)
        self._place = {name: i for i, name in enumerate(self.joints)}
        ids = np.array([model.joint(name).id for name in self.joints], dtype=np.int64)
        self.joint_ids = ids
        self._qpos = model.jnt_qposadr[ids]
        self._dofs = model.jnt_dofadr[ids]
        hinge = model.jnt_type[ids] == mujoco.mjtJoint.mjJNT_HINGE
        self._unit = np.where(hinge, math.pi / 180, 1.0)
        limited = model.jnt_limited[ids].astype(bool)
        #: The joints' ranges [rad or m] and greatest speeds [rad/s or m/s].
        self.low: FloatArray = np.where(limited, model.jnt_range[ids, 0], -np.inf)
        self.high: FloatArray = np.where(limited, model.jnt_range[ids, 1], np.inf)
        self.speeds = self._speeds(velocities)
        self.rest: FloatArray = np.clip(np.zeros(len(ids)), self.low, self.high)
        for i, value in self.set_points("rest", description.rest).items():
            self.rest[i] = value
        self._wheel_ids = [model.actuator(name).id for name in wheel_names]
        self._servo_ids = np.array([model.actuator(n).id for n in self.joints], dtype=np.int64)
        self._tune()
        self._read_head()
        self._stand(start)

    # ---- names and numbers of the mapping

    def index(self, key: str, name: str) -> int:
        """The place of a joint among `joints`.

        Args:
            key: where the mapping names it.
            name: the joint.

        Raises:
            DataError: the model has no such joint with a servo.
        """
        self._require(key, name, self.joints)
        return self._place[name]

    def set_points(self, key: str, joints: Mapping[str, float]) -> dict[int, float]:
        """Angles or ways of the mapping as set-points by index [rad or m].

        Raises:
            DataError: a joint is unknown or its value out of its range.
        """
        points: dict[int, float] = {}
        for name, value in joints.items():
            i = self.index(key, name)
            point = value * self._unit[i]
            if not self.low[i] - 1e-9 <= point <= self.high[i] + 1e-9:
                low, high = self.low[i] / self._unit[i], self.high[i] / self._unit[i]
                raise self.description.error(
                    f"{key}: {name} goes from {low:.4g} to {high:.4g}, not to {value:g}"
                )
            points[i] = float(point)
        return points

    # ---- the state

    @property
    def pose(self) -> Pose2D:
        """The base in the world."""
        x, y, yaw = self.data.qpos[:3].tolist()
        return Pose2D(x, y, wrap_angle(yaw))

    @property
    def angles(self) -> FloatArray:
        """Where the joints are [rad or m], in the order of `joints`."""
        where: FloatArray = self.data.qpos[self._qpos]
        return where

    @property
    def velocities(self) -> FloatArray:
        """How fast they move [rad/s or m/s]."""
        fast: FloatArray = self.data.qvel[self._dofs]
        return fast

    @property
    def base_speeds(self) -> tuple[float, float]:
        """Forward [m/s] and to the left [rad/s]."""
        vx, vy, turn = self.data.qvel[:3].tolist()
        yaw = self.data.qpos[2]
        return vx * math.cos(yaw) + vy * math.sin(yaw), turn

    @property
    def aimed(self) -> FloatArray:
        """The set-points the servos now hold [rad or m]; a copy."""
        held: FloatArray = self.data.act.copy()
        return held

    @property
    def still(self) -> bool:
        """Whether everything has come to rest."""
        return bool(np.abs(self.data.qvel).max() < 1e-4)

    def sight(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Position [m] and rotation matrix (3, 3) of a site or body in the world."""
        frame = self.data.site(name) if name in self.sites else self.data.body(name)
        return frame.xpos, frame.xmat.reshape(3, 3)

    def advance(self, targets: FloatArray, speed: float, turn_rate: float) -> None:
        """Let one control cycle pass.

        Args:
            targets: where the set-points shall be after it [rad or m]; they go there as fast
                as the joints may.
            speed: the base's, forward [m/s].
            turn_rate: the base's, to the left [rad/s].
        """
        data = self.data
        control = data.ctrl
        control[0], control[1] = speed, turn_rate
        control[self._servo_ids] = (targets - data.act) / CYCLE
        if self._wheel_ids:
            wheels = self.description.wheels
            assert wheels is not None
            left, right = self._wheel_ids
            sideways = turn_rate * wheels.track / 2
            control[left] = (speed - sideways) / wheels.radius * self._rolls[0]
            control[right] = (speed + sideways) / wheels.radius * self._rolls[1]
        mujoco.mj_step(self.model, data, STEPS_A_CYCLE)

    def settle(self) -> None:
        """Compute where everything is now; a step leaves places one step old."""
        mujoco.mj_kinematics(self.model, self.data)

    # ---- building

    def _require(self, key: str, name: str, valid: tuple[str, ...] | list[str]) -> None:
        if name not in valid:
            raise self.description.error(f"{key}: {UnknownNameError('joint', name, valid)}")

    def _speeds(self, velocities: Mapping[str, float]) -> FloatArray:
        """Each joint's greatest speed: by its name, else a pattern, else the URDF's."""
        given = self.description.speeds
        for pattern in given:
            if not any(fnmatchcase(name, pattern) for name in self.joints):
                raise self.description.error(
                    f"speeds: {UnknownNameError('joint', pattern, self.joints)}"
                )
        speeds = []
        for name in self.joints:
            by_pattern = (v for pattern, v in given.items() if fnmatchcase(name, pattern))
            speed = given.get(name) or next(by_pattern, None) or velocities.get(name)
            if speed is None:
                raise self.description.error(
                    f"speeds lacks {name!r} (a pattern such as 'arm_*' or '*' will do)"
                )
            speeds.append(speed)
        return np.array(speeds)

    def _tune(self) -> None:
        """Give every servo its stiffness, damping and limits, by the inertia it moves."""
        model = self.model
        inertia = model.dof_M0  # with all joints at zero
        for i, servo in enumerate(self._servo_ids):
            stiffness = SERVO_FREQUENCY**2 * inertia[self._dofs[i]]
            damping = 2 * SERVO_FREQUENCY * inertia[self._dofs[i]]
            model.actuator_gainprm[servo, 0] = stiffness
            model.actuator_biasprm[servo, 1:3] = -stiffness, -damping
            model.actuator_ctrllimited[servo] = 1
            model.actuator_ctrlrange[servo] = -self.speeds[i], self.speeds[i]
            if np.isfinite(self.low[i]):
                model.actuator_actrange[servo] = self.low[i], self.high[i]
                model.actuator_actlimited[servo] = 1
        for servo in (0, 1, 2, *self._wheel_ids):
            if servo < 3:
                mass = inertia[2] if servo == 1 else inertia[0]
            else:
                mass = inertia[model.jnt_dofadr[model.actuator_trnid[servo, 0]]]
            model.actuator_gainprm[servo, 0] = mass / SPEED_LAG
            model.actuator_biasprm[servo, 2] = -mass / SPEED_LAG

    def _read_head(self) -> None:
        """The geometry of head and eyes, with all joints at zero."""
        description, model, data = self.description, self.model, self.data
        head = description.head
        self.sites = {model.site(i).name for i in range(model.nsite)}
        sights = self.sites | {model.body(i).name for i in range(1, model.nbody)}
        named = [("head.face", head.face), ("hand", description.hand)]
        named += [(f"eyes[{i}].site", eye.site) for i, eye in enumerate(description.eyes)]
        for key, name in named:
            if name is not None and name not in sights:
                raise description.error(
                    f"{key}: {UnknownNameError('site or body', name, sorted(sights))}"
                )
        self.pan, self.tilt = self.index("head.pan", head.pan), self.index("head.tilt", head.tilt)
        self.eyes = tuple(
            self.index(f"eyes[{i}].joint", eye.joint) for i, eye in enumerate(description.eyes)
        )
        data.qpos[:] = 0.0
        mujoco.mj_kinematics(model, data)
        face = self.sight(head.face)
        pan, tilt = int(self.joint_ids[self.pan]), int(self.joint_ids[self.tilt])
        self.head = HeadGeometry(model, data, pan, tilt, face)
        upright, left = float(data.xaxis[pan][2]), float(data.xaxis[tilt] @ np.cross(
            data.xaxis[pan] * np.sign(data.xaxis[pan][2]), face[1][:, 0]
        ))  # fmt: skip
        if not self.head.square or abs(upright) < 0.99:
            raise description.error(
                "the head needs a pan joint about the vertical, then a tilt joint across it, and"
                f" a face whose x axis looks ahead; {head.pan}, {head.tilt} and {head.face} are"
                " not so"
            )
        #: What the joints' angles are multiplied with to be positive to the left and up.
        self.pan_sign, self.tilt_sign = math.copysign(1, upright), -math.copysign(1, left)
        self.eye_pointers = tuple(
            Pointer(model, data, int(self.joint_ids[i]), self.sight(eye.site))
            for i, eye in zip(self.eyes, description.eyes, strict=True)
        )
        for i, (eye, pointer) in enumerate(zip(description.eyes, self.eye_pointers, strict=True)):
            if pointer.blind:
                raise description.error(
                    f"eyes[{i}]: {eye.joint} does not turn where {eye.site} looks"
                )
        wheels = description.wheels
        if wheels is not None:
            self._rolls = [
                math.copysign(1, float(data.xaxis[model.joint(name).id][1]))
                for name in (wheels.left, wheels.right)
            ]

    def _stand(self, start: Pose2D) -> None:
        data = self.data
        data.qpos[:] = 0.0
        data.qpos[self._qpos] = self.rest
        mujoco.mj_kinematics(self.model, data)
        x, y, z = self.sight(self.description.head.face)[0].tolist()
        #: The face in the base frame while the joints rest [m].
        self.face: Vec3 = (x, y, z)
        data.qpos[:3] = start
        data.act[:] = self.rest
        mujoco.mj_forward(self.model, data)
