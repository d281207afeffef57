"""A person before a camera, live.

A camera drops frames, and its plug comes loose. What is missing is told, time goes on meanwhile
with nobody seen, and a camera that comes back within `RECONNECT` is read on.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Generator
from typing import Any, ClassVar

from kendon.errors import DataError
from kendon.sources.base import SourceOptions, register
from kendon.sources.camera_geometry import check_fov, import_cv2
from kendon.sources.pictures import DetectorMaker, Picture, PictureSource, detector_maker
from kendon.sources.quiet import quiet_stderr

#: A camera that gives nothing for so long is opened anew [s]; less are dropped frames.
DROPPED = 0.5
#: So long it is tried to get a camera back [s].
RECONNECT = 10.0
#: Between two tries to read a frame, and to open the camera [s].
_READ_AGAIN, _OPEN_AGAIN = 0.02, 0.5
#: A camera that has just been opened may need so long for its first frame [s].
_WARM_UP = 3.0

#: Opens a camera: a `cv2.VideoCapture`, or None where it does not open.
CameraOpener = Callable[[int], Any]


@register
class CameraSource(PictureSource):
    """The person before a camera.

    Args:
        index: the camera's number.
        options: of the source.
        make_detectors: called when the first picture is wanted.
        open_camera: opens it at first and again when it was lost.
        clock: tells the time [s].
        sleep: waits some seconds.
    """

    name: ClassVar[str] = "camera"
    reads: ClassVar[str] = "faces before a camera, live; the number picks the camera"
    example: ClassVar[str] = "camera:0"
    live: ClassVar[bool] = True

    def __init__(
        self,
        index: int,
        options: SourceOptions,
        make_detectors: DetectorMaker,
        open_camera: CameraOpener,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        super().__init__(options, make_detectors)
        self._index = index
        self._open_camera = open_camera
        self._clock, self._sleep = clock, sleep
        self._capture: Any | None = open_camera(index)
        if self._capture is None:
            raise DataError(
                f"camera {index} does not open; check that it is plugged in, that no other"
                f" program uses it, that you may read it (on Linux: /dev/video{index}, group"
                " video), and that its number is right (camera:0 is the first)"
            )

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """Whether `spec` is ``camera`` or starts with ``camera:``."""
        return spec == "camera" or spec.startswith("camera:")

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> CameraSource:
        """Open a camera by its number; ``camera`` alone is ``camera:0``.

        Raises:
            DataError: the number is none, that camera does not open, or the calibration cannot
                be read.
            ParameterError: the camera's field of view is not one of a camera.
            MissingExtraError: the ``camera`` extra is not installed.
            ModelFileError: a network's file cannot be had.
        """
        match = re.fullmatch(r"camera(?::(\d{1,3}))?", spec)
        if match is None:
            raise DataError(f"{spec!r} names no camera; write camera, camera:0, camera:1, ...")
        check_fov(options.fov)
        return cls(int(match[1] or 0), options, detector_maker(options), open_capture)

    def pictures(self) -> Generator[Picture, None, None]:
        """The camera's pictures, stamped from the first one's arrival on [s].

        While the camera gives none there are pictures without an image; when it does not come
        back within `RECONNECT`, they end, and a note says so.

        Raises:
            DataError: the camera never gives a picture.
        """
        try:
            yield from self._read()
        finally:
            self.close()

    def close(self) -> None:
        """Let go of the camera."""
        if self._capture is not None:
            self._capture.release()
            self._capture = None

    def _read(self) -> Generator[Picture, None, None]:
        first = math.nan  # [s], when the first picture came
        given = opened = self._clock()  # [s], when the last one came; when it was last opened
        count = 0
        t = -math.inf
        while True:
            good, image = self._next()
            now = self._clock()
            if good:
                if count == 0:
                    first = now
                elif now - given > DROPPED:
                    self.notes += (
                        f"camera {self._index} gave nothing from {given - first:.1f} to"
                        f" {now - first:.1f} s; nobody was seen meanwhile",
                    )
                count, given = count + 1, now
                # A clock of coarse steps may tell two frames the same time; stamps must grow.
                t = max(now - first, t + 1e-6)
                yield Picture(t, image, now)
                continue
            if now - given > RECONNECT:
                self._end(count, given - first)
                return
            wait = _OPEN_AGAIN if self._capture is None else _WARM_UP
            if now - given > DROPPED and now - opened > wait:
                self.close()
                self._capture, opened = self._open_camera(self._index), self._clock()
            elif count and now - first > t + 0.1:
                t = now - first
                yield Picture(t, None, now)
            self._sleep(_READ_AGAIN)

    def _next(self) -> tuple[bool, Any]:
        if self._capture is None:
            return False, None
        cv2 = import_cv2("reading a camera")
        try:
            good, image = self._capture.read()
        except cv2.error:  # some drivers' way to say that the camera is gone
            return False, None
        return bool(good) and image is not None, image

    def _end(self, count: int, last: float) -> None:
        """Say that the camera is gone.

        Raises:
            DataError: it never gave a picture, so that there is nothing to go on with.
        """
        if not count:
            raise DataError(
                f"camera {self._index} opens but gives no picture within {RECONNECT:g} s; check"
                " its cable and whether another program uses it"
            )
        self.notes += (
            f"camera {self._index} stopped giving pictures at {last:.1f} s and did not come back"
            f" within {RECONNECT:g} s; what was read until then counts",
        )


def open_capture(index: int) -> Any:
    """An open `cv2.VideoCapture` of a camera; None where it does not open."""
    cv2 = import_cv2("reading a camera")
    with quiet_stderr():
        capture = cv2.VideoCapture(index)
    if not capture.isOpened():
        capture.release()
        return None
    # An old frame is of no use to a robot: keep no more than one waiting.
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    return capture
