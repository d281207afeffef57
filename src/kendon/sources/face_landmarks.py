"""MediaPipe's Face Landmarker: from a part of a picture to one face's landmarks and blendshapes.

The thin shell around the neural network; what its numbers mean is worked out in
`kendon.sources.face_geometry`. MediaPipe is imported when a landmarker is made, not before.
"""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from kendon.errors import MissingExtraError, ModelFileError
from kendon.sources.camera_geometry import FloatArray, import_cv2
from kendon.sources.face_finder import FaceBox
from kendon.sources.quiet import quiet_stderr

ByteImage = NDArray[np.uint8]

#: The window that is cut out around a face, in heights or widths of the face, whichever is more:
#: hair, chin and both ears are in it, and so is the way a face goes between two frames.
_MARGIN = 1.6
#: The window is brought to this many pixels: the landmark network itself looks at 256 x 256.
_INPUT = 256
#: Landmarks of the skin; those behind them are the irises'.
_SKIN = 468


class Window(NamedTuple):
    """A square part of a picture; it may reach beyond the picture's rim."""

    x: int  # [px], left rim
    y: int  # [px], upper rim
    side: int  # [px]

    @classmethod
    def around(cls, box: FaceBox) -> Window:
        """The window in which a face is read."""
        side = max(math.ceil(_MARGIN * max(box.width, box.height)), 2)
        x, y = box.centre
        return cls(round(x - side / 2), round(y - side / 2), side)


@dataclass(frozen=True)
class FaceReading:
    """One face as the network sees it."""

    landmarks: FloatArray  # (478, 2) [px] of the whole image
    blendshapes: Mapping[str, float]  # score 0 to 1 by MediaPipe's name; empty when unknown

    @property
    def box(self) -> FaceBox:
        """The upright box around the landmarks of the skin."""
        low, high = self.landmarks[:_SKIN].min(axis=0), self.landmarks[:_SKIN].max(axis=0)
        (x, y), (width, height) = low.tolist(), (high - low).tolist()
        return FaceBox(x, y, width, height)


class FaceLandmarks(Protocol):
    """What reading several faces needs of a landmarker."""

    def read(self, rgb: ByteImage, window: Window) -> FaceReading | None:
        """The face in a window of a picture (height, width, 3); None where there is none."""

    def close(self) -> None:
        """Give the network's memory back; nothing may be read afterwards."""


class FaceLandmarker:
    """Reads one face at a time with MediaPipe's Tasks API.

    Every window is read for itself (MediaPipe's image mode). Its video mode would follow a face
    from frame to frame in coordinates of a picture that here moves along with the face, and
    would smooth the face's motion away with the window's.

    Args:
        model: the path of ``face_landmarker.task``.

    Raises:
        MissingExtraError: MediaPipe or OpenCV is not installed.
        ModelFileError: MediaPipe cannot read the model.
    """

    def __init__(self, model: Path) -> None:
        self._mediapipe = import_mediapipe()
        self._cv2 = import_cv2("reading faces")
        self._warm = False
        tasks, vision = self._mediapipe.tasks, self._mediapipe.tasks.vision
        options = vision.FaceLandmarkerOptions(
            base_options=tasks.BaseOptions(model_asset_path=str(model)),
            running_mode=vision.RunningMode.IMAGE,
            num_faces=1,
            output_face_blendshapes=True,
        )
        try:
            with quiet_stderr():
                self._landmarker = vision.FaceLandmarker.create_from_options(options)
        except (RuntimeError, ValueError, OSError) as error:
            raise ModelFileError(f"{model}: MediaPipe cannot read this model: {error}") from error

    def read(self, rgb: ByteImage, window: Window) -> FaceReading | None:
        """The face in a window of a picture (height, width, 3); None where there is none."""
        part = self._cut(rgb, window)
        image = self._mediapipe.Image(image_format=self._mediapipe.ImageFormat.SRGB, data=part)
        # The networks are set up, and say so, in the first call.
        with contextlib.nullcontext() if self._warm else quiet_stderr():
            result = self._landmarker.detect(image)
        self._warm = True
        if not result.face_landmarks:
            return None
        shares = np.array([(p.x, p.y) for p in result.face_landmarks[0]], dtype=np.float64)
        return FaceReading(
            shares * window.side + (window.x, window.y),
            {shape.category_name: float(shape.score) for shape in result.face_blendshapes[0]},
        )

    def close(self) -> None:
        """Give the network's memory back; nothing may be read afterwards."""
        with quiet_stderr():
            self._landmarker.close()

    def _cut(self, rgb: ByteImage, window: Window) -> ByteImage:
        """The window, black where it lies outside the picture, at the network's size."""
        cv2, (x, y, side), (height, width) = self._cv2, window, rgb.shape[:2]
        left, top = min(max(-x, 0), side), min(max(-y, 0), side)
        right, bottom = min(max(x + side - width, 0), side), min(max(y + side - height, 0), side)
        part = rgb[max(y, 0) : max(y + side, 0), max(x, 0) : max(x + side, 0)]
        if not part.size:
            return np.zeros((_INPUT, _INPUT, 3), dtype=np.uint8)
        if left or top or right or bottom:
            part = cv2.copyMakeBorder(part, top, bottom, left, right, cv2.BORDER_CONSTANT)
        way = cv2.INTER_AREA if side > _INPUT else cv2.INTER_CUBIC
        return np.ascontiguousarray(cv2.resize(part, (_INPUT, _INPUT), interpolation=way))


def import_mediapipe() -> Any:
    """MediaPipe, imported only when it is needed, and told to keep its log to errors.

    Raises:
        MissingExtraError: it is not installed.
    """
    # Read once, when the native library is loaded; a user's own setting stays.
    os.environ.setdefault("GLOG_minloglevel", "2")
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "2")
    try:
        import mediapipe
    except ImportError as error:
        raise MissingExtraError("reading faces in a video", "camera", "mediapipe") from error
    return mediapipe
