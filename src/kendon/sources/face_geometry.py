"""What 478 face landmarks in an image say about a person, in metres: head, eyes, gaze, smile.

Everything here is pure: landmarks, blendshapes and a camera in, numbers out. The detector that
finds the landmarks is in `kendon.sources.face_landmarks`.

**Frames.** *optical* and *image* as in `kendon.sources.camera_geometry`. The *head* frame has its
origin halfway between the eyes on the face, x out of the face, y to the person's left, z up. A
person who faces the camera has their left on the image's right.

**Scale.** One camera cannot tell a small face near by from a large one far off, so an adult of
mean size is assumed: `FACE_POINTS` puts the middles of the two eyes 63.1 mm apart; the mean
interpupillary distance of adults is 63.4 mm with a standard deviation of 3.8 mm (Dodgson 2004,
"Variation and extrema of human interpupillary distance"). Distances therefore carry a scale error
of about 6 % (one standard deviation) that stays the same for one person. The iris, 11.7 mm in
nearly everyone, is the worse ruler here: the network draws it up to 15 % too wide under half-closed
lids (13.9 px where the picture shows 12.1 px, 0.45 m instead of 0.54 m).

**Why not the network's own pose.** MediaPipe's facial transformation matrix assumes a camera with
63 degrees of *vertical* field of view. Multiplying its depth by the ratio of the focal lengths
gives the distance back to within 3 %, but not the rotation: a face beside the image's middle is
seen along an oblique ray, and the wrong ray turns the head. On a face 10 degrees beside the middle
the matrix is 6 degrees off in the median and has the head point to the wrong side of the camera.
Solving for the pose with the camera's own intrinsics has no such error, and costs 0.4 ms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kendon.sources.camera_geometry import Intrinsics, import_cv2

FloatArray = NDArray[np.float64]

#: Number of landmarks of one face: 468 of the skin, 5 of each iris.
LANDMARKS = 478

#: Landmarks that hold still while a face speaks and smiles, in the head frame [mm]: forehead,
#: bridge and tip of the nose, eye corners, temples. Their places are those of MediaPipe's
#: canonical face (Apache-2.0), rounded to 0.1 mm. With the wings of the nose, the cheeks or the
#: whole face added, the misfit in the image grows by half to fourfold, the pose by 1 to 3 degrees.
FACE_POINTS: Mapping[int, tuple[float, float, float]] = {
    10: (10.2, 0.0, 56.4),  # middle of the forehead, at the hair
    168: (17.7, 0.0, 6.5),  # bridge of the nose, at eye height
    6: (23.2, 0.0, -1.5),
    197: (28.5, 0.0, -9.0),
    5: (37.8, 0.0, -22.6),
    4: (41.2, 0.0, -30.9),  # tip of the nose
    33: (-2.9, -44.5, 0.4),  # right eye, outer corner
    133: (2.9, -18.6, -0.4),  # right eye, inner corner
    362: (2.9, 18.6, -0.4),  # left eye, inner corner
    263: (-2.9, 44.5, 0.4),  # left eye, outer corner
    127: (-54.7, -77.4, -2.6),  # right temple, in front of the ear
    356: (-54.7, 77.4, -2.6),  # left temple
}
_POINT_IDS = list(FACE_POINTS)
_POINTS: FloatArray = np.array(list(FACE_POINTS.values())) / 1000.0

#: Corners and iris centre of the person's (left, right) eye.
EYE_CORNERS = ((362, 263), (33, 133))
IRIS_CENTRES = (473, 468)

#: From the eye's centre of rotation to the middle of the iris [m]: the limbus, a circle of
#: 11.7 mm, lies on a globe of 12 mm radius, so its plane is sqrt(12^2 - 5.85^2) mm off the centre.
IRIS_DEPTH = math.sqrt(0.012**2 - 0.00585**2)

#: The eye's centre of rotation as seen from the middle between the eye's corners, for the left
#: eye, in the head frame [m]; y is mirrored for the right eye. Backward: the cornea stands about
#: 7.5 mm before that middle (Hertel exophthalmometry) and 13.5 mm before the centre of rotation.
#: Outward and upward: the mean offset of the iris where people look straight into the camera.
EYE_OFFSET: tuple[float, float, float] = (-0.006, 0.001, 0.0025)

#: Above this mean of the eyeBlink blendshapes the lids cover so much of the iris that its place is
#: a guess, whether in a blink or in looking far down.
BLINK_THRESHOLD = 0.5

#: The part of the eyeSquint blendshape that a lid on its way down brings along by itself, measured
#: over one blink of a smiling face (squint +0.21 while blink +0.37).
_SQUINT_OF_BLINK = 0.5
#: Excess squint that counts as the strongest cheek raise (AU06 = 5).
_FULL_SQUINT = 0.7

#: Nearer than this a face does not fit into a picture [m].
_MIN_DEPTH = 0.05


@dataclass(frozen=True)
class HeadPose:
    """Where a head is in the camera's optical frame."""

    position: FloatArray  # (3,) [m], the head frame's origin
    rotation: FloatArray  # (3, 3), directions: head -> optical
    misfit: float  # [px], root mean square distance of the projected points from the landmarks


@dataclass(frozen=True)
class Eyes:
    """Both eyes in the camera's optical frame, the person's left one first."""

    centres: FloatArray  # (2, 3) [m], centres of rotation
    gaze: FloatArray  # (2, 3), unit directions


def head_pose(pixels: FloatArray, camera: Intrinsics) -> HeadPose | None:
    """The pose that explains best where `FACE_POINTS` appear in the image.

    The depths that the network guesses for its landmarks are not used.

    Args:
        pixels: the landmarks, (478, 2) or (468, 2) [px].
        camera: the camera that took the image.

    Returns:
        The pose, or None where no face in front of the camera explains the landmarks.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    cv2 = import_cv2("reading head poses")
    seen = np.ascontiguousarray(pixels[_POINT_IDS], dtype=np.float64)
    if not np.isfinite(seen).all():
        return None
    # SQPnP finds the global minimum without a first guess; the refinement then minimises the
    # distance in the image, which is what the landmarks' noise is even in.
    try:
        found, turn, shift = cv2.solvePnP(
            _POINTS, seen, camera.matrix, None, flags=cv2.SOLVEPNP_SQPNP
        )
        if not found:
            return None
        turn, shift = cv2.solvePnPRefineLM(_POINTS, seen, camera.matrix, None, turn, shift)
    except cv2.error:  # landmarks that lie on top of each other
        return None
    position = np.asarray(shift, dtype=np.float64).reshape(3)
    rotation = np.asarray(cv2.Rodrigues(turn)[0], dtype=np.float64)
    if not (np.isfinite(rotation).all() and position[2] > _MIN_DEPTH):
        return None
    error = camera.project(_POINTS @ rotation.T + position) - seen
    return HeadPose(position, rotation, float(np.sqrt(np.mean(np.sum(error**2, axis=-1)))))


def eyes(pixels: FloatArray, pose: HeadPose, camera: Intrinsics) -> Eyes:
    """Where the eyes are and where they look, by a globe behind each pair of eye corners.

    The corners are taken from the image (eyes differ from person to person by more millimetres
    than the iris moves in a glance) and put at the depth that the head pose gives them; the
    centre of rotation lies `EYE_OFFSET` from their middle. The ray through the iris meets the
    sphere that the iris moves on; where it passes beside it, the nearest point is taken.

    Args:
        pixels: the landmarks, (478, 2) [px].
        pose: the head's pose by `head_pose`.
        camera: the camera that took the image.
    """
    centres, gaze = np.empty((2, 3)), np.empty((2, 3))
    for i, (corners, iris) in enumerate(zip(EYE_CORNERS, IRIS_CENTRES, strict=True)):
        model = np.mean([FACE_POINTS[corner] for corner in corners], axis=0) / 1000.0
        depth = float((pose.rotation @ model + pose.position)[2])
        middle = camera.rays(pixels[list(corners)].mean(axis=0)) * depth
        back, outward, up = EYE_OFFSET
        offset = np.array([back, outward if i == 0 else -outward, up])
        centres[i] = middle + pose.rotation @ offset
        ray = camera.rays(pixels[iris])
        gaze[i] = _towards_iris(ray / np.linalg.norm(ray), centres[i])
    return Eyes(centres, gaze)


def _towards_iris(ray: FloatArray, centre: FloatArray) -> FloatArray:
    """The unit direction from an eye's centre to where `ray` first meets the iris's sphere."""
    along = float(ray @ centre)
    beside = ray * along - centre  # from the centre to the ray's nearest point
    inside = IRIS_DEPTH**2 - float(beside @ beside)
    direction = beside - ray * math.sqrt(max(inside, 0.0))
    return np.asarray(direction / np.linalg.norm(direction))


def lids_down(blendshapes: Mapping[str, float]) -> bool:
    """Whether the lids cover the irises, by the mean of both eyeBlink blendshapes."""
    return _mean(blendshapes, "eyeBlink") > BLINK_THRESHOLD


def action_units(blendshapes: Mapping[str, float]) -> tuple[float, float]:
    """The intensities of AU06 (cheek raiser) and AU12 (lip corner puller), each 0 to 5.

    Blendshapes are not action units: they are amounts by which an animated face is deformed.

    - AU12 = 5 s², s the mean of mouthSmileLeft and mouthSmileRight. The blendshape saturates
      early (0.5 for a hint of a smile, 0.9 for every broad one); the square spreads it. Like the
      action unit it knows nothing of joy: a sob pulls the lip corners, too, and scores.
    - AU06: MediaPipe's cheekSquint blendshapes stay at 0.00 through the broadest smile, so the
      raised cheek is read from what it does to the lower lid: eyeSquint, less the part that a
      blink brings along, as a share of 0.7. Narrow eyes and bright light squint as well, so it
      counts only as far as the lip corners are pulled: AU06 = 5 s · share. It is therefore not an
      AU06 that could tell a felt smile from a posed one.

    Args:
        blendshapes: score by name, each 0 to 1; names as MediaPipe writes them.
    """
    smile = _mean(blendshapes, "mouthSmile")
    squint = _mean(blendshapes, "eyeSquint") - _SQUINT_OF_BLINK * _mean(blendshapes, "eyeBlink")
    share = min(max(squint / _FULL_SQUINT, 0.0), 1.0)
    return 5.0 * smile * share, 5.0 * smile**2


def smile_intensity(blendshapes: Mapping[str, float]) -> float:
    """The smile feature, the mean of AU06 and AU12 (thesis 3.11), 0 to 5; NaN without scores."""
    au06, au12 = action_units(blendshapes)
    return (au06 + au12) / 2.0


def _mean(blendshapes: Mapping[str, float], name: str) -> float:
    """The mean of a blendshape's left and right half, within 0 to 1; NaN where one is missing."""
    value = sum(blendshapes.get(f"{name}{side}", math.nan) for side in ("Left", "Right")) / 2.0
    return value if math.isnan(value) else min(max(value, 0.0), 1.0)
