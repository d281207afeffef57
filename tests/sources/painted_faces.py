"""Faces without networks: landmarks by geometry, detectors that see what they are told."""

from __future__ import annotations

from typing import Any

import numpy as np

from kendon.sources.camera_geometry import Intrinsics
from kendon.sources.face_finder import ByteImage, FaceBox
from kendon.sources.face_geometry import FACE_POINTS, LANDMARKS
from kendon.sources.face_landmarks import FaceReading, Window
from kendon.sources.face_reader import SeenFace
from kendon.sources.pictures import Detectors

#: Head axes in the optical frame of a person who looks along the camera's axis, as columns.
FACING = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
WIDTH, HEIGHT = 320, 240
CAMERA = Intrinsics.from_fov(WIDTH, HEIGHT)


def turned(yaw: float) -> Any:
    """A head turned to its own left [rad], as axes in the optical frame."""
    c, s = np.cos(yaw), np.sin(yaw)
    return FACING @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def face_at(
    x: float, y: float, z: float, *, blink: float = 0.0, yaw: float = 0.0,
    camera: Intrinsics = CAMERA,
) -> FaceReading:  # fmt: skip
    """A face at a place of the optical frame [m]; with yaw 0 it looks along the camera's axis."""
    rotation = turned(yaw)
    place = np.array([x, y, z])
    # All landmarks that mean nothing lie on the tip of the nose, inside the face.
    pixels = np.tile(camera.project(rotation @ (np.array(FACE_POINTS[4]) / 1000) + place),
                     (LANDMARKS, 1))  # fmt: skip
    for i, point in FACE_POINTS.items():
        pixels[i] = camera.project(rotation @ (np.array(point) / 1000) + place)
    pixels[473], pixels[468] = pixels[[362, 263]].mean(axis=0), pixels[[33, 133]].mean(axis=0)
    shapes = {"mouthSmile": 0.8, "eyeSquint": 0.4, "eyeBlink": blink}
    both = {f"{name}{side}": v for name, v in shapes.items() for side in ("Left", "Right")}
    return FaceReading(pixels, both)


def seen(number: int, reading: FaceReading) -> SeenFace:
    """A face with its number."""
    return SeenFace(number, reading.box, reading)


class ToldDetector:
    """Sees the faces it is told to, picture by picture, then none."""

    def __init__(self, *faces: list[SeenFace]) -> None:
        self.faces = list(faces)
        self.closed = False
        self.images: list[ByteImage] = []

    def detect(self, bgr: ByteImage, t: float) -> list[SeenFace]:
        self.images.append(bgr)
        return self.faces.pop(0) if self.faces else []

    def close(self) -> None:
        self.closed = True

    @property
    def both(self) -> Detectors:
        """As a source wants it."""
        return Detectors(self, None)


class ToldFinder:
    """Finds the boxes that it holds."""

    def __init__(self, *boxes: FaceBox) -> None:
        self.boxes = list(boxes)
        self.searches = 0

    def find(self, bgr: ByteImage) -> list[FaceBox]:
        self.searches += 1
        return sorted(self.boxes, key=lambda box: -box.size)


class ToldLandmarks:
    """Reads the face, of those that it holds, that lies in the middle of the window."""

    def __init__(self, *readings: FaceReading) -> None:
        self.readings = list(readings)
        self.windows: list[Window] = []
        self.closed = False

    def read(self, rgb: ByteImage, window: Window) -> FaceReading | None:
        self.windows.append(window)
        middle = np.array([window.x, window.y]) + window.side / 2
        for reading in self.readings:
            away = np.abs(np.array(reading.box.centre) - middle)
            if (away < 0.3 * window.side).all() and reading.box.width < window.side:
                return reading
        return None

    def close(self) -> None:
        self.closed = True
