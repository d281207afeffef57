"""MediaPipe's Pose Landmarker: from a picture to the landmarks of the bodies in it.

The thin shell around the neural network; `kendon.sources.body_joints` works out what its numbers
mean. kendon comes with no file for it: there are three of different speed (lite, full, heavy), and
the user picks one with ``--pose-model FILE``.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from kendon.errors import ModelFileError
from kendon.sources.body_joints import BodyReading
from kendon.sources.camera_geometry import import_cv2
from kendon.sources.face_finder import ByteImage
from kendon.sources.face_landmarks import import_mediapipe
from kendon.sources.quiet import quiet_stderr

#: Where the three files are to be had, for messages.
ORIGIN = "https://ai.google.dev/edge/mediapipe/solutions/vision/pose_landmarker"


class BodyDetector(Protocol):
    """What a video source needs for joints."""

    def detect(self, bgr: ByteImage, t: float) -> list[BodyReading]:
        """The bodies in a picture (height, width, 3), stamped `t` [s]; stamps must grow."""

    def close(self) -> None:
        """Give the network's memory back; nothing may be detected afterwards."""


class PoseLandmarker:
    """Reads bodies with MediaPipe's Tasks API in its video mode, which follows them.

    Args:
        model: the path of one of MediaPipe's ``pose_landmarker_*.task``.
        most: how many bodies are looked for.

    Raises:
        MissingExtraError: MediaPipe is not installed.
        ModelFileError: the file is missing, or MediaPipe cannot read it.
    """

    def __init__(self, model: Path, most: int) -> None:
        self._mediapipe = import_mediapipe()
        self._cv2 = import_cv2("reading bodies")
        self._last_stamp = -1  # [ms]
        self._warm = False
        check_pose_model(model)
        tasks, vision = self._mediapipe.tasks, self._mediapipe.tasks.vision
        options = vision.PoseLandmarkerOptions(
            base_options=tasks.BaseOptions(model_asset_path=str(model)),
            running_mode=vision.RunningMode.VIDEO,
            num_poses=most,
        )
        try:
            with quiet_stderr():
                self._landmarker = vision.PoseLandmarker.create_from_options(options)
        except (RuntimeError, ValueError, OSError) as error:
            raise ModelFileError(
                f"{model}: MediaPipe cannot read this as a pose landmarker: {error}"
            ) from error

    def detect(self, bgr: ByteImage, t: float) -> list[BodyReading]:
        """The bodies in a picture (height, width, 3), stamped `t` [s]; stamps must grow."""
        # MediaPipe refuses a stamp that does not grow in whole milliseconds.
        self._last_stamp = max(round(t * 1000.0), self._last_stamp + 1)
        rgb = self._cv2.cvtColor(bgr, self._cv2.COLOR_BGR2RGB)
        image = self._mediapipe.Image(image_format=self._mediapipe.ImageFormat.SRGB, data=rgb)
        with contextlib.nullcontext() if self._warm else quiet_stderr():
            result = self._landmarker.detect_for_video(image, self._last_stamp)
        self._warm = True
        height, width = bgr.shape[:2]
        return bodies_of(result, width, height)

    def close(self) -> None:
        """Give the network's memory back; nothing may be detected afterwards."""
        with quiet_stderr():
            self._landmarker.close()


def check_pose_model(model: Path) -> None:
    """Refuse a file that is not there.

    Raises:
        ModelFileError: it is missing.
    """
    if not model.is_file():
        raise ModelFileError(
            f"--pose-model {model}: there is no such file; get pose_landmarker_lite.task, _full or"
            f" _heavy from {ORIGIN}"
        )


def bodies_of(result: Any, width: int, height: int) -> list[BodyReading]:
    """The bodies of a Pose Landmarker's result.

    Args:
        result: a ``PoseLandmarkerResult``, live or recorded.
        width: of the image [px].
        height: of the image [px].
    """
    return [
        BodyReading(
            np.array([(p.x * width, p.y * height) for p in image], dtype=np.float64),
            np.array([(p.x, p.y, p.z) for p in world], dtype=np.float64),
            np.array([p.visibility or 0.0 for p in image], dtype=np.float64),
        )
        for image, world in zip(result.pose_landmarks, result.pose_world_landmarks, strict=True)
    ]
