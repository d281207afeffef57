"""From the faces of one video frame to the one person kendon greets."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from kendon.geometry import Vec3
from kendon.person import PersonFrame
from kendon.sources.camera_geometry import FloatArray, Intrinsics, MountedCamera
from kendon.sources.face_geometry import HeadPose, eyes, head_pose, lids_down, smile_intensity
from kendon.sources.face_landmarks import FaceReading

#: Nobody greeting moves faster than a jog [m/s].
MAX_SPEED = 2.5
#: What a face may seem to jump between two frames while standing still [m].
JUMP = 0.3
#: So long a person may be out of sight and still be waited for [s]; then the nearest one counts.
PATIENCE = 1.0
#: A blink lasts 0.1 to 0.4 s (Stern, Walrath and Goldstein 1984) [s]. Lids that stay down longer
#: are lowered on purpose, to look down or to shut out the view: that is where the person looks.
LONGEST_BLINK = 0.4


class FaceFollower:
    """Keeps to one person among several.

    The rule: start with the nearest face. From then on take the face nearest to where the
    followed one was last, as long as it could have moved there (`JUMP` plus `MAX_SPEED` times
    the time since). If no face could, nobody is seen; after `PATIENCE` start again.
    """

    def __init__(self) -> None:
        self._last: FloatArray | None = None  # (3,) [m]
        self._seen = -math.inf  # [s]

    def choose(self, heads: Sequence[FloatArray], t: float) -> int | None:
        """Which of the heads is the followed person's; None when none is.

        Args:
            heads: positions, each (3,) [m], in the camera's optical frame.
            t: the frame's stamp [s].
        """
        chosen: int | None = None
        if self._last is None or t - self._seen > PATIENCE:
            chosen = min(
                range(len(heads)), key=lambda i: float(np.linalg.norm(heads[i])), default=None
            )
        elif heads:
            ways = [float(np.linalg.norm(head - self._last)) for head in heads]
            nearest = int(np.argmin(ways))
            if ways[nearest] <= JUMP + MAX_SPEED * (t - self._seen):
                chosen = nearest
        if chosen is not None:
            self._last, self._seen = heads[chosen], t
        return chosen


class PersonReader:
    """Turns the faces of each frame into a `PersonFrame` in the robot's base frame.

    During a blink the direction of the eyes is unknown. Once the lids have been down for longer
    than `LONGEST_BLINK`, it is what can be made out of it, downward: taken as unknown, it would
    leave the word to the head, and somebody who faces the robot with closed eyes would count as
    looking at it.

    Args:
        camera: the camera that took the images.
        mounted: how it sits on the robot.
    """

    def __init__(self, camera: Intrinsics, mounted: MountedCamera) -> None:
        self._camera = camera
        self._mounted = mounted
        self._follower = FaceFollower()
        self._closed_since = math.nan  # [s]; NaN while the eyes are open

    def read(self, faces: Sequence[FaceReading], t: float) -> PersonFrame:
        """The followed person at `t` [s]; a frame with unknown head when nobody is seen."""
        size = np.array([self._camera.width, self._camera.height], dtype=np.float64)
        seen: list[tuple[FaceReading, FloatArray, HeadPose]] = []
        for face in faces:
            pixels = face.landmarks * size
            pose = head_pose(pixels, self._camera)
            if pose is not None:
                seen.append((face, pixels, pose))
        chosen = self._follower.choose([pose.position for _, _, pose in seen], t)
        if chosen is None:
            self._closed_since = math.nan
            return PersonFrame(t)
        return self._person(t, *seen[chosen])

    def _person(
        self, t: float, face: FaceReading, pixels: FloatArray, pose: HeadPose
    ) -> PersonFrame:
        both = eyes(pixels, pose, self._camera)
        centres = self._mounted.points(both.centres)
        gaze = self._mounted.directions(both.gaze)
        return PersonFrame(
            t,
            head=_vec3(self._mounted.points(pose.position)),
            head_rotation=self._mounted.quaternion(pose.rotation),
            eyes=(_vec3(centres[0]), _vec3(centres[1])),
            eye_gaze=None if self._blinks(face, t) else (_vec3(gaze[0]), _vec3(gaze[1])),
            smile=smile_intensity(face.blendshapes),
        )

    def _blinks(self, face: FaceReading, t: float) -> bool:
        if not lids_down(face.blendshapes):
            self._closed_since = math.nan
            return False
        if math.isnan(self._closed_since):
            self._closed_since = t
        return t - self._closed_since <= LONGEST_BLINK


def _vec3(values: FloatArray) -> Vec3:
    return (float(values[0]), float(values[1]), float(values[2]))
