"""Shoulders, elbows, wrists and hips in metres, from what MediaPipe's Pose Landmarker gives.

The network gives every joint twice: its place in the image, and its place in metres about the
middle of the hips (*world landmarks*), for a person of a size that it guesses. Where that body
stands is the pose that explains best where the joints appear in the image (PnP). A camera cannot
tell a small body near by from a large one far off, but the face's distance is known: the body is
scaled about the camera's centre until its eyes are as far away as the face. The image stays
the same under that scaling, so nothing of what was seen is given up.

Pure: landmarks and a camera in, joints out. The network's shell is in
`kendon.sources.pose_landmarks`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kendon.sources.camera_geometry import FloatArray, Intrinsics, import_cv2
from kendon.sources.face_finder import FaceBox

#: Number of landmarks of one body.
LANDMARKS = 33
#: kendon's joints in MediaPipe's numbering; left and right are the person's own.
JOINT_LANDMARKS: Mapping[str, int] = {
    "l_shoulder": 11, "r_shoulder": 12, "l_elbow": 13, "r_elbow": 14,
    "l_wrist": 15, "r_wrist": 16, "l_hip": 23, "r_hip": 24,
}  # fmt: skip
#: The eyes' middles: they lie where the head frame of `FACE_POINTS` begins.
_EYES = (2, 5)
#: Joints that hold the body together: the pose comes from those of them that are seen. Feet,
#: fingers and the face's details add their own errors and little else.
_BODY = (2, 5, 7, 8, 11, 12, 13, 14, 15, 16, 23, 24, 25, 26)
#: A joint counts as seen from this visibility on, 0 to 1.
VISIBLE = 0.5
#: PnP needs so many points to be more than a guess.
_FEWEST = 6
#: How far the joints may lie from where the placed body has them, in distances between the
#: shoulders: farther, the two sets of landmarks contradict each other.
_MISFIT = 0.25
#: The guessed body may be so much too small or too large; beyond that it is not this face's.
_SCALES = (0.6, 1.7)


@dataclass(frozen=True)
class BodyReading:
    """One body as the network sees it."""

    image: FloatArray  # (33, 2) [px] of the whole image
    world: FloatArray  # (33, 3) [m] about the middle of the hips; x right, y down, z forward
    visibility: FloatArray  # (33,) 0 to 1

    @property
    def face(self) -> tuple[float, float]:
        """The middle between the eyes [px]."""
        x, y = self.image[list(_EYES)].mean(axis=0).tolist()
        return (x, y)


def body_joints(body: BodyReading, head: FloatArray, camera: Intrinsics) -> dict[str, FloatArray]:
    """The joints that are seen, by name, each (3,) [m] in the camera's optical frame.

    Args:
        body: one person's landmarks.
        head: that person's face, the point between the eyes, (3,) [m] in the optical frame.
        camera: the camera that took the image.

    Returns:
        Empty where too little of the body is seen, or what is seen is no body of this face.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    used = [i for i in _BODY if _seen(body, i, camera)]
    if len(used) < _FEWEST or not set(_EYES) <= set(used):
        return {}
    seen = camera.straighten(body.image)
    placed = _placed(body.world, seen, used, camera)
    if placed is None:
        return {}
    scale = float(np.linalg.norm(head) / np.linalg.norm(placed[list(_EYES)].mean(axis=0)))
    if not _SCALES[0] < scale < _SCALES[1]:
        return {}
    return {
        name: placed[i] * scale for name, i in JOINT_LANDMARKS.items() if _seen(body, i, camera)
    }


def match_bodies(bodies: list[BodyReading], faces: Mapping[int, FaceBox]) -> dict[int, BodyReading]:
    """Whose body is whose: by the number of the face that the body's eyes lie in."""
    matched: dict[int, BodyReading] = {}
    for number, box in faces.items():
        inside = [
            body
            for body in bodies
            if abs(body.face[0] - box.centre[0]) < box.width / 2
            and abs(body.face[1] - box.centre[1]) < box.height / 2
        ]
        if inside:
            matched[number] = min(
                inside, key=lambda body: abs(body.face[0] - box.centre[0]) / box.width
            )
    return matched


def _seen(body: BodyReading, i: int, camera: Intrinsics) -> bool:
    """Whether a joint is in the picture: beyond its rim the network makes joints up."""
    x, y = body.image[i].tolist()
    return bool(
        body.visibility[i] >= VISIBLE and 0 <= x <= camera.width and 0 <= y <= camera.height
    )


def _placed(
    world: FloatArray, seen: FloatArray, used: list[int], camera: Intrinsics
) -> FloatArray | None:
    """The body where it appears in the image, (33, 3) [m]; None where it fits nowhere."""
    cv2 = import_cv2("reading bodies")
    points = np.ascontiguousarray(world[used], dtype=np.float64)
    pixels = np.ascontiguousarray(seen[used], dtype=np.float64)
    if not (np.isfinite(points).all() and np.isfinite(pixels).all()):
        return None
    try:
        found, turn, shift = cv2.solvePnP(
            points, pixels, camera.matrix, None, flags=cv2.SOLVEPNP_SQPNP
        )
        if not found:
            return None
        turn, shift = cv2.solvePnPRefineLM(points, pixels, camera.matrix, None, turn, shift)
    except cv2.error:  # landmarks that lie on top of each other
        return None
    placed = np.asarray(world @ cv2.Rodrigues(turn)[0].T + shift.reshape(3), dtype=np.float64)
    if not (np.isfinite(placed).all() and (placed[used, 2] > 0).all()):
        return None
    wide = float(np.linalg.norm(placed[11] - placed[12])) * camera.focal / placed[11, 2]
    misfit = np.sqrt(np.mean(np.sum((camera.project(placed[used]) - pixels) ** 2, axis=1)))
    return placed if misfit <= _MISFIT * max(wide, 1.0) else None
