"""From the faces of one picture to people in the robot's frame, and the one who is greeted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kendon.geometry import Vec3
from kendon.person import PersonFrame
from kendon.sources.camera_geometry import FloatArray, Intrinsics, MountedCamera
from kendon.sources.face_choice import FACING, Candidate, GreetedChoice
from kendon.sources.face_geometry import Eyes, HeadPose, eyes, head_pose, lids_down, smile_intensity
from kendon.sources.face_landmarks import FaceReading
from kendon.sources.face_reader import SeenFace

#: A blink lasts 0.1 to 0.4 s (Stern, Walrath and Goldstein 1984) [s]. Lids that stay down longer
#: are lowered on purpose, to look down or to shut out the view: that is where the person looks.
LONGEST_BLINK = 0.4

#: How wide an adult's face is between the temples in the picture [m]; see `FACE_POINTS`.
FACE_WIDTH = 0.155
#: With fewer pixels from temple to temple a face says nothing certain, not even where it is [px].
SMALLEST_HEAD = 32.0
#: With fewer, its irises (3 px across) and the corners of its mouth say nothing [px].
SMALLEST_EYES = 40.0
#: The pose's misfit, as a share of the face's size, beyond which the landmarks are no face that is
#: wholly seen: half hidden behind somebody, a face of 3.2 m was placed at 3.8 m with 0.046. Whole
#: faces, bowed and tilted, had at most 0.029.
MOST_MISFIT = 0.04
#: So long nobody is seen when the greeted person changes [s]: an interval between observations
#: and a frame, so that no speed is made up of the way from one person to the other.
_CHANGE = 0.25


@dataclass(frozen=True)
class SeenPerson:
    """One person of a picture, in the camera's and in the robot's frame."""

    face: SeenFace
    pose: HeadPose | None  # None where the face is too far away or turned away
    eyes: Eyes | None  # None where their gaze is not known, too
    frame: PersonFrame  # in base; its head is unknown where the pose is


@dataclass(frozen=True)
class Scene:
    """Everybody in one picture, and who is greeted."""

    people: tuple[SeenPerson, ...]
    greeted: int | None  # a number; None where that person is not seen
    frame: PersonFrame  # the greeted one; a frame with unknown head when they are not seen


def head_range(camera: Intrinsics) -> float:
    """How far away a face may be so that its place is told [m]."""
    return camera.focal * FACE_WIDTH / SMALLEST_HEAD


def eyes_range(camera: Intrinsics) -> float:
    """How far away a face may be so that eyes and smile are told [m]."""
    return camera.focal * FACE_WIDTH / SMALLEST_EYES


class PersonReader:
    """Turns the faces of each picture into people, one of them greeted.

    During a blink the direction of the eyes is unknown. Once the lids have been down for longer
    than `LONGEST_BLINK`, it is what can be made out of it, downward: taken as unknown, it would
    leave the word to the head, and somebody who faces the robot with closed eyes would count as
    looking at it.

    Args:
        camera: the camera that took the images.
        mounted: how it sits on the robot.
        only: the number of the one person to follow; None to choose (`GreetedChoice`).
    """

    def __init__(self, camera: Intrinsics, mounted: MountedCamera, only: int | None = None) -> None:
        self.camera = camera
        self._mounted = mounted
        self._choice = GreetedChoice(only)
        self._closed_since: dict[int, float] = {}  # [s], by the number of the face
        self._greeted: int | None = None  # the last one who was
        self._changed = -math.inf  # [s]

    def read(
        self,
        faces: Sequence[SeenFace],
        t: float,
        joints: Mapping[int, Mapping[str, FloatArray]] | None = None,
    ) -> Scene:
        """Everybody at `t` [s].

        Args:
            faces: those of the picture.
            t: the picture's stamp [s].
            joints: by the face's number, places of joints in the optical frame [m].
        """
        people = tuple(self._person(face, t, (joints or {}).get(face.number)) for face in faces)
        candidates = [
            Candidate(
                one.face.number,
                float(np.linalg.norm(one.pose.position)),
                _faces_camera(one.pose),
            )
            for one in people
            if one.pose is not None
        ]
        greeted = self._choice.choose(candidates, t)
        frame = next((p.frame for p in people if p.face.number == greeted), PersonFrame(t))
        if greeted is not None and greeted != self._greeted:
            if self._greeted is not None:
                self._changed = t
            self._greeted = greeted
        if t - self._changed < _CHANGE:
            frame = PersonFrame(t)
        self._closed_since = {
            one.face.number: since
            for one in people
            if (since := self._closed_since.get(one.face.number)) is not None
        }
        return Scene(people, greeted, frame)

    def pose(self, face: SeenFace) -> tuple[FloatArray, HeadPose] | None:
        """The landmarks as a pinhole shows them [px], and the pose.

        None past the range, and where the landmarks are those of no face that is wholly seen.
        """
        if face.reading is None:
            return None
        pixels = self.camera.straighten(face.reading.landmarks)
        pose = head_pose(pixels, self.camera)
        if (
            pose is None
            or pose.position[2] > head_range(self.camera)
            or pose.misfit > MOST_MISFIT * face.reading.box.size
        ):
            return None
        return pixels, pose

    def _person(
        self, face: SeenFace, t: float, joints: Mapping[str, FloatArray] | None
    ) -> SeenPerson:
        found = self.pose(face)
        if found is None or face.reading is None:
            return SeenPerson(face, None, None, PersonFrame(t))
        pixels, pose = found
        frame = PersonFrame(
            t,
            head=_vec3(self._mounted.points(pose.position)),
            head_rotation=self._mounted.quaternion(pose.rotation),
            joints={
                name: _vec3(self._mounted.points(place)) for name, place in (joints or {}).items()
            },
            who=face.number,
        )
        if pose.position[2] > eyes_range(self.camera):
            return SeenPerson(face, pose, None, frame)
        both = eyes(pixels, pose, self.camera)
        centres = self._mounted.points(both.centres)
        gaze = self._mounted.directions(both.gaze)
        blinks = self._blinks(face.number, face.reading, t)
        frame = frame._replace(
            eyes=(_vec3(centres[0]), _vec3(centres[1])),
            eye_gaze=None if blinks else (_vec3(gaze[0]), _vec3(gaze[1])),
            smile=smile_intensity(face.reading.blendshapes),
        )
        return SeenPerson(face, pose, None if blinks else both, frame)

    def _blinks(self, number: int, reading: FaceReading, t: float) -> bool:
        if not lids_down(reading.blendshapes):
            self._closed_since.pop(number, None)
            return False
        return t - self._closed_since.setdefault(number, t) <= LONGEST_BLINK


def _faces_camera(pose: HeadPose) -> bool:
    toward = -pose.position / np.linalg.norm(pose.position)
    return float(pose.rotation[:, 0] @ toward) > math.cos(FACING)


def _vec3(values: FloatArray) -> Vec3:
    return (float(values[0]), float(values[1]), float(values[2]))
