"""What a robot's sensors make of a person: noise, blind ranges, dropped frames, short losses."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kendon.errors import ParameterError, UnknownNameError
from kendon.person import JOINTS, FloatArray, Track


@dataclass(frozen=True)
class Sensor:
    """How a face detector sees: all of it applied to frames, before any feature.

    Raises:
        ParameterError: a value is out of its range.
    """

    range_noise: float = 0.0  # standard deviation of the distance, as a share of it
    head_noise: float = 0.0  # standard deviation of the head's yaw and pitch [rad]
    face_range: float = math.inf  # farther away gaze and smile are unknown [m]
    dropped: float = 0.0  # share of frames in which nobody is found
    loss: float = 0.0  # length of one stretch in which nobody is found [s]
    joint_noise: float = 0.0  # standard deviation of each joint in each direction [m]
    joint_memory: float = 0.1  # how long that noise takes to be forgotten [s]
    arm_loss: float = 0.0  # share of the time in which an arm is hidden, in stretches
    joints_seen: tuple[str, ...] = JOINTS  # the others are never found

    def __post_init__(self) -> None:
        for name, high in (
            ("range_noise", 1.0), ("head_noise", math.pi), ("face_range", math.inf),
            ("dropped", 0.99), ("loss", math.inf), ("joint_noise", math.inf),
            ("joint_memory", math.inf), ("arm_loss", 0.99),
        ):  # fmt: skip
            if not 0 <= getattr(self, name) <= high:
                raise ParameterError(
                    f"a sensor's {name} lies between 0 and {high:g}, not {getattr(self, name)}"
                )
        for joint in self.joints_seen:
            if joint not in JOINTS:
                raise UnknownNameError("joint", joint, JOINTS)

    def see(self, track: Track, rng: np.random.Generator) -> Track:
        """What the sensor makes of a track. Given gestures and true phases stay as they are."""
        frames = len(track)
        # The noise is along the line of sight: a face's size tells its distance, its place in
        # the image the direction.
        stretch = 1 + rng.normal(0, self.range_noise, frames) if self.range_noise else 1.0
        head = track.head * np.reshape(stretch, (-1, 1))
        head[:, 2] = track.head[:, 2]
        rotation, smile = track.head_rotation.copy(), track.smile.copy()
        eyes, eye_gaze = track.eyes.copy(), track.eye_gaze.copy()
        if self.head_noise:
            rotation = _shake(rotation, rng.normal(0, self.head_noise, (2, frames)))

        far = np.hypot(track.head[:, 0], track.head[:, 1]) > self.face_range
        lost = rng.random(frames) < self.dropped
        if self.loss and track.duration > self.loss:
            begin = track.t[0] + rng.uniform(0, track.duration - self.loss)
            lost |= (track.t >= begin) & (track.t < begin + self.loss)
        for values in (rotation, smile, eyes, eye_gaze):
            values[far | lost] = np.nan
        joints = (
            self._see_joints(track, np.nan_to_num(head - track.head), rng) if track.joints else {}
        )
        for places in joints.values():
            places[lost] = np.nan
        head[lost] = np.nan
        return replace(
            track,
            head=head,
            head_rotation=rotation,
            smile=smile,
            eyes=eyes,
            eye_gaze=eye_gaze,
            joints=joints,
        )

    def _see_joints(
        self, track: Track, shift: FloatArray, rng: np.random.Generator
    ) -> dict[str, FloatArray]:
        """Joints misplaced with the face, as one depth image does, and each by itself."""
        rng = rng.spawn(1)[0]  # what is drawn of faces does not depend on joints
        period = track.duration / max(len(track) - 1, 1)
        kept = math.exp(-period / self.joint_memory) if self.joint_memory else 0.0
        seen = {}
        for name in (name for name in track.joints if name in self.joints_seen):
            seen[name] = track.joints[name] + shift
            if self.joint_noise:
                seen[name] += self.joint_noise * _lasting_noise(rng, len(track), kept)
        for side in "lr":
            hidden = _stretches(rng, track.t, self.arm_loss)
            for name in (f"{side}_elbow", f"{side}_wrist"):
                if name in seen:
                    seen[name][hidden] = np.nan
        return seen


_NO_HIPS = tuple(joint for joint in JOINTS if not joint.endswith("hip"))
#: How long an arm stays hidden on average [s]; ours.
HIDDEN = 0.8


def _lasting_noise(rng: np.random.Generator, frames: int, kept: float) -> FloatArray:
    """Noise of size 1 of which a share is kept from frame to frame (first order); (frames, 3)."""
    from scipy.signal import lfilter  # a second: not for those who need none

    fresh = rng.normal(0, 1, (frames, 3))
    fresh[1:] *= math.sqrt(1 - kept * kept)
    return np.asarray(lfilter([1.0], [1.0, -kept], fresh, axis=0))


def _stretches(rng: np.random.Generator, t: FloatArray, share: float) -> NDArray[np.bool_]:
    """When something is hidden: stretches of random length that fill a share of the time."""
    hidden = np.zeros(len(t), dtype=bool)
    if share:
        pause = HIDDEN * (1 - share) / share
        begin = t[0] + (rng.exponential(pause) if rng.random() >= share else 0.0)
        while begin < t[-1]:
            length = rng.exponential(HIDDEN)
            hidden |= (t >= begin) & (t < begin + length)
            begin += length + rng.exponential(pause)
    return hidden


def _shake(rotation: FloatArray, angles: FloatArray) -> FloatArray:
    """Turn heads by a yaw and a pitch in their own frames; quaternions (N, 4), angles (2, N)."""
    (sy, cy), (sp, cp) = ((np.sin(a / 2), np.cos(a / 2)) for a in angles)
    turn = np.stack([-sy * sp, cy * sp, sy * cp, cy * cp], axis=-1)  # yaw after pitch
    ax, ay, az, aw = rotation.T
    bx, by, bz, bw = turn.T
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


#: Sensors by name. "noisy" is a face detector on a moving robot's camera in a poor light.
SENSORS: dict[str, Sensor] = {
    "clean": Sensor(),
    "noisy": Sensor(
        range_noise=0.05, head_noise=math.radians(15), face_range=4.0, dropped=0.12, loss=0.7
    ),
}


def sensor(name: str, seed: int = 0) -> Callable[[Track], Track]:
    """A sensor of a name, as a function of tracks.

    What it does to a track depends on the seed and the track's name alone, not on the order in
    which tracks are seen.

    Raises:
        UnknownNameError: there is no such sensor.
    """
    if name not in SENSORS:
        raise UnknownNameError("sensor", name, SENSORS)

    def see(track: Track) -> Track:
        return SENSORS[name].see(
            track, np.random.default_rng([seed, zlib.crc32(track.name.encode())])
        )

    return see


def draw_sensor(rng: np.random.Generator) -> Sensor:
    """A sensor as robots have them, from a laser's precision to a bad camera's.

    Range noise up to 6 %, head pose within 3 to 20 degrees (what detectors state for near and
    far faces), gaze and smile known up to 3 to 12 m, up to 15 % of the frames and in a third of
    the encounters a stretch of up to 1 s lost. Joints within 0.5 to 5 cm (from motion capture
    to depth cameras, Wang et al. 2015, and single images), arms hidden up to 15 % of the time;
    every fourth sensor finds no hips, every eighth nothing but the face.
    """
    joints = rng.spawn(1)[0]  # what is drawn of faces does not depend on joints
    kind = joints.random()
    return Sensor(
        range_noise=float(rng.uniform(0.0, 0.06)),
        head_noise=math.radians(rng.uniform(3, 20)),
        face_range=float(rng.uniform(3, 12)),
        dropped=float(rng.uniform(0, 0.15)),
        loss=float(rng.uniform(0.3, 1.0)) if rng.random() < 1 / 3 else 0.0,
        joint_noise=float(np.exp(joints.uniform(*np.log((0.005, 0.05))))),
        joint_memory=float(joints.uniform(0.0, 0.3)),
        arm_loss=float(joints.uniform(0, 0.15)) if joints.random() < 0.5 else 0.0,
        joints_seen=() if kind < 1 / 8 else _NO_HIPS if kind < 3 / 8 else JOINTS,
    )
