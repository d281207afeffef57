"""OpenCV's YuNet: where in a picture there are faces, down to about 30 pixels of width.

MediaPipe's own face detector looks at 128 x 128 pixels of the whole picture, in which a face
beyond two metres covers a few: it is made for selfies. YuNet (Wu, Peng and Yu 2023, "YuNet: a tiny
millisecond-level face detector") looks at every pixel.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from kendon.errors import ModelFileError
from kendon.sources.camera_geometry import import_cv2
from kendon.sources.quiet import quiet_stderr

ByteImage = NDArray[np.uint8]

#: Longest side of the picture that is searched [px]; larger ones are shrunk. Searching 1280 x 720
#: costs about 90 ms of one slow core, and what is 30 pixels wide there is farther than 5 m.
_LONGEST = 1280
#: YuNet was trained on faces of up to 300 pixels: larger ones are found in the picture shrunk to
#: a longest side of so many pixels, which costs little [px].
_SHORT_SEARCH = 320
#: How sure YuNet must be, 0 to 1. False finds are no harm: Face Landmarker sees no face there.
_SCORE = 0.6
#: Boxes that overlap by more than this share are one face.
_OVERLAP = 0.3
_MOST = 50


class FaceBox(NamedTuple):
    """A face's upright box in the image."""

    x: float  # [px], left rim
    y: float  # [px], upper rim
    width: float  # [px]
    height: float  # [px]

    @property
    def centre(self) -> tuple[float, float]:
        """The middle [px]."""
        return (self.x + self.width / 2, self.y + self.height / 2)

    @property
    def size(self) -> float:
        """The side of a square as large [px]: it changes less than either side as a head turns."""
        return math.sqrt(self.width * self.height)

    def overlap(self, other: FaceBox) -> float:
        """Intersection over union with another box, 0 to 1."""
        wide = min(self.x + self.width, other.x + other.width) - max(self.x, other.x)
        high = min(self.y + self.height, other.y + other.height) - max(self.y, other.y)
        shared = max(wide, 0.0) * max(high, 0.0)
        union = self.width * self.height + other.width * other.height - shared
        return shared / union if union > 0 else 0.0


class FaceFinder(Protocol):
    """What reading several faces needs of a detector."""

    def find(self, bgr: ByteImage) -> list[FaceBox]:
        """The faces of a picture (height, width, 3), the largest first."""


class YuNet:
    """Finds faces with `cv2.FaceDetectorYN`.

    Args:
        model: the path of YuNet's file.

    Raises:
        MissingExtraError: OpenCV is not installed.
        ModelFileError: OpenCV cannot read the model.
    """

    def __init__(self, model: Path) -> None:
        self._cv2 = import_cv2("finding faces")
        self._detectors: dict[tuple[int, int], Any] = {}
        self._model = model
        self._detector(_SHORT_SEARCH, _SHORT_SEARCH)

    def find(self, bgr: ByteImage) -> list[FaceBox]:
        """The faces of a picture (height, width, 3), the largest first."""
        longest = max(bgr.shape[:2])
        boxes = self._search(bgr, min(1.0, _LONGEST / longest))
        if longest > _SHORT_SEARCH:
            boxes += self._search(bgr, _SHORT_SEARCH / longest)
        boxes.sort(key=lambda box: -box.size)
        kept: list[FaceBox] = []
        for box in boxes:
            if all(box.overlap(other) < _OVERLAP for other in kept):
                kept.append(box)
        return kept

    def _search(self, bgr: ByteImage, scale: float) -> list[FaceBox]:
        height, width = bgr.shape[:2]
        if scale < 1.0:
            size = max(round(width * scale), 1), max(round(height * scale), 1)
            bgr = self._cv2.resize(bgr, size, interpolation=self._cv2.INTER_AREA)
        found = self._detector(bgr.shape[1], bgr.shape[0]).detect(bgr)[1]
        if found is None:
            return []
        across, down = width / bgr.shape[1], height / bgr.shape[0]
        return [
            FaceBox(x * across, y * down, w * across, h * down)
            for x, y, w, h in np.asarray(found, dtype=np.float64)[:, :4].tolist()
            if w > 0 and h > 0
        ]

    def _detector(self, width: int, height: int) -> Any:
        """The network set up for one size: setting up anew for each picture would cost more."""
        if (width, height) not in self._detectors:
            try:
                with quiet_stderr():
                    self._detectors[width, height] = self._cv2.FaceDetectorYN.create(
                        str(self._model), "", (width, height), _SCORE, _OVERLAP, _MOST
                    )
            except self._cv2.error as error:
                raise ModelFileError(
                    f"{self._model}: OpenCV {self._cv2.__version__} cannot read this model"
                ) from error
        return self._detectors[width, height]
