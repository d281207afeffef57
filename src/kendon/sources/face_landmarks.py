"""MediaPipe's Face Landmarker: from the frames of a video to landmarks and blendshapes.

The thin shell around the neural network; what its numbers mean is worked out in
`kendon.sources.face_geometry`. MediaPipe is imported when a detector is made, not before.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kendon.errors import MissingExtraError, ModelFileError
from kendon.sources.face_geometry import FloatArray

ByteImage = NDArray[np.uint8]

#: So many people may stand before the robot without the one it greets being passed over. Each
#: further face costs its own run of the landmark network, about 15 ms on one core; looking for
#: more than one turns MediaPipe's smoothing off (a still head then trembles by 0.8 mm a frame
#: instead of 0.2 mm, and a gaze by 0.9 instead of 0.3 degrees), which the median over an
#: observation's 0.2 s makes up for.
MAX_FACES = 4


@dataclass(frozen=True)
class FaceReading:
    """One face as the network sees it."""

    landmarks: FloatArray  # (478, 2), x and y as shares of the image's width and height
    blendshapes: Mapping[str, float]  # score 0 to 1 by MediaPipe's name; empty when unknown


class FaceDetector(Protocol):
    """What a video source needs of a detector."""

    def detect(self, rgb: ByteImage, t: float) -> list[FaceReading]:
        """All faces of one frame, (height, width, 3), stamped `t` [s]; stamps must grow."""

    def close(self) -> None:
        """Give the network's memory back; nothing may be detected afterwards."""


class FaceLandmarker:
    """A detector with MediaPipe's Tasks API in its video mode, which follows faces between frames.

    Args:
        model: the path of ``face_landmarker.task``.
        max_faces: how many faces are looked for.

    Raises:
        MissingExtraError: MediaPipe is not installed.
        ModelFileError: MediaPipe cannot read the model.
    """

    def __init__(self, model: Path, max_faces: int = MAX_FACES) -> None:
        self._mediapipe = import_mediapipe()
        self._last_stamp = -1  # [ms]
        self._warm = False
        tasks, vision = self._mediapipe.tasks, self._mediapipe.tasks.vision
        options = vision.FaceLandmarkerOptions(
            base_options=tasks.BaseOptions(model_asset_path=str(model)),
            running_mode=vision.RunningMode.VIDEO,
            num_faces=max_faces,
            output_face_blendshapes=True,
        )
        try:
            with quiet_stderr():
                self._landmarker = vision.FaceLandmarker.create_from_options(options)
        except (RuntimeError, ValueError, OSError) as error:
            raise ModelFileError(f"{model}: MediaPipe cannot read this model: {error}") from error

    def detect(self, rgb: ByteImage, t: float) -> list[FaceReading]:
        """All faces of one frame, (height, width, 3), stamped `t` [s]; stamps must grow."""
        # MediaPipe refuses a stamp that does not grow in whole milliseconds.
        self._last_stamp = max(round(t * 1000.0), self._last_stamp + 1)
        image = self._mediapipe.Image(
            image_format=self._mediapipe.ImageFormat.SRGB, data=np.ascontiguousarray(rgb)
        )
        # The networks are set up, and say so, in the first call.
        with contextlib.nullcontext() if self._warm else quiet_stderr():
            result = self._landmarker.detect_for_video(image, self._last_stamp)
        self._warm = True
        return [
            FaceReading(
                np.array([(point.x, point.y) for point in landmarks], dtype=np.float64),
                {shape.category_name: float(shape.score) for shape in shapes},
            )
            for landmarks, shapes in zip(
                result.face_landmarks, result.face_blendshapes, strict=True
            )
        ]

    def close(self) -> None:
        """Give the network's memory back; nothing may be detected afterwards."""
        with quiet_stderr():
            self._landmarker.close()

    def __enter__(self) -> FaceLandmarker:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


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


@contextlib.contextmanager
def quiet_stderr() -> Iterator[None]:
    """Send what native code writes to the standard error stream nowhere, for a moment.

    MediaPipe, TensorFlow Lite and FFmpeg print past Python, onto the terminal that shows the
    live timeline. The stream is the whole process's, so this is held only while a model is set
    up or a file is opened; what goes wrong there comes back as an exception.
    """
    if sys.stderr is not None:
        sys.stderr.flush()
    try:
        saved = os.dup(2)
    except OSError:  # no standard error stream, as under pythonw: nothing to keep quiet
        yield
        return
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        os.close(nowhere)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
