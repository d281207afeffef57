"""What a robot's sensors make of a person frame by frame, and only of what is in their view."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kendon.errors import ParameterError
from kendon.geometry import Quaternion, Vec3, compose, wrap_angle
from kendon.person import PersonFrame
from kendon.robots.base import Appearance
from kendon.simulation.sensors import HIDDEN, Sensor


@dataclass(frozen=True)
class View:
    """What a camera in the robot's face takes in.

    Raises:
        ParameterError: an angle is not between 0 and the full circle.
    """

    width: float = math.radians(80)  # [rad]; a common wide webcam's, 16:9
    height: float = math.radians(50)  # [rad]

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            if not 0 < getattr(self, name) <= 2 * math.pi:
                raise ParameterError(
                    f"a field of view's {name} lies between 0 and 360 degrees, not"
                    f" {math.degrees(getattr(self, name)):g}"
                )

    def holds(self, point: Vec3, robot: Appearance) -> bool:
        """Whether a point in the world lies in the view of a robot's face."""
        dx, dy, dz = (there - here for there, here in zip(point, robot.face, strict=True))
        gx, gy, gz = robot.gaze
        aside = wrap_angle(math.atan2(dy, dx) - math.atan2(gy, gx))
        above = math.atan2(dz, math.hypot(dx, dy)) - math.atan2(gz, math.hypot(gx, gy))
        return abs(aside) <= self.width / 2 and abs(above) <= self.height / 2


class LiveSensor:
    """A sensor that is handed one frame after the other.

    The noise is that of `Sensor.see`, but for what only a whole track can tell: the one stretch
    of loss begins at an instant drawn beforehand.

    Args:
        sensor: how it sees.
        view: what it sees at all; None = whatever direction the robot looks in.
        seed: of chance.
        horizon: within how long the stretch of loss begins [s].
    """

    def __init__(
        self, sensor: Sensor, view: View | None = None, *, seed: int = 0, horizon: float = 8.0
    ) -> None:
        self.sensor = sensor
        self.view = view
        self._rng = np.random.default_rng(seed)
        self._lost_from = float(self._rng.uniform(0, horizon))
        self._t = math.nan
        self._joint_noise: dict[str, np.ndarray[tuple[int], np.dtype[np.float64]]] = {}
        self._hidden_until = {"l": -math.inf, "r": -math.inf}

    def see(self, frame: PersonFrame, robot: Appearance) -> PersonFrame:
        """What is seen of a person.

        Args:
            frame: the person in the robot's base frame.
            robot: as it stands.
        """
        sensor, rng = self.sensor, self._rng
        dt = 0.0 if self._t != self._t else frame.t - self._t
        self._t = frame.t
        unseen = PersonFrame(frame.t, robot=frame.robot, who=frame.who)
        if not frame.seen:
            return unseen
        if self.view and not self.view.holds(frame.robot.to_world(frame.head), robot):
            return unseen
        lost = sensor.loss and self._lost_from <= frame.t < self._lost_from + sensor.loss
        if lost or (sensor.dropped and rng.random() < sensor.dropped):
            return unseen
        x, y, z = frame.head
        stretch = 1 + rng.normal(0, sensor.range_noise) if sensor.range_noise else 1.0
        head = (x * stretch, y * stretch, z)
        if math.hypot(x, y) > sensor.face_range:
            return frame._replace(
                head=head, head_rotation=_UNKNOWN, eyes=None, eye_gaze=None,
                smile=math.nan, joints=self._joints(frame, head, dt),
            )  # fmt: skip
        rotation = frame.head_rotation
        if sensor.head_noise:
            rotation = _shake(rotation, *rng.normal(0, sensor.head_noise, 2).tolist())
        return frame._replace(
            head=head, head_rotation=rotation, joints=self._joints(frame, head, dt)
        )

    def _joints(self, frame: PersonFrame, head: Vec3, dt: float) -> dict[str, Vec3]:
        """Joints misplaced with the face, and each by itself; some hidden for a while."""
        sensor, rng = self.sensor, self._rng
        shift_x, shift_y = head[0] - frame.head[0], head[1] - frame.head[1]
        hidden = {side: self._hidden(side, frame.t, dt) for side in "lr"}
        seen = {}
        names = [name for name in frame.joints if name in sensor.joints_seen]
        if sensor.joint_noise and names:
            kept = math.exp(-dt / sensor.joint_memory) if sensor.joint_memory else 0.0
            fresh = rng.normal(0, 1, (len(names), 3))
            for name, new in zip(names, fresh, strict=True):
                old = self._joint_noise.get(name)
                mixed = new if old is None else kept * old + math.sqrt(1 - kept * kept) * new
                self._joint_noise[name] = mixed
        for name in names:
            if hidden[name[0]] and name.endswith(("elbow", "wrist")):
                continue
            x, y, z = frame.joints[name]
            dx, dy, dz = (
                (sensor.joint_noise * self._joint_noise[name]).tolist()
                if sensor.joint_noise
                else (0.0, 0.0, 0.0)
            )
            seen[name] = (x + shift_x + dx, y + shift_y + dy, z + dz)
        return seen

    def _hidden(self, side: str, t: float, dt: float) -> bool:
        """Whether an arm is hidden: stretches of random length that fill a share of the time."""
        share = self.sensor.arm_loss
        if not share:
            return False
        if t < self._hidden_until[side]:
            return True
        pause = HIDDEN * (1 - share) / share
        if self._rng.random() < -math.expm1(-dt / pause):
            self._hidden_until[side] = t + float(self._rng.exponential(HIDDEN))
            return True
        return False


_UNKNOWN: Quaternion = (math.nan, math.nan, math.nan, math.nan)


def _shake(rotation: Quaternion, yaw: float, pitch: float) -> Quaternion:
    """Turn a head by a yaw and a pitch in its own frame."""
    turn = compose(
        (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)),
        (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2)),
    )
    return compose(rotation, turn)
