"""A camera with a script, and a clock that is told the time."""

from __future__ import annotations

from typing import Any

import numpy as np
from sources.painted_faces import HEIGHT, WIDTH, ToldDetector, face_at, seen

from kendon.sources.face_finder import ByteImage
from kendon.sources.face_reader import SeenFace

PERIOD = 0.1


class Clock:
    """Time goes on when somebody waits."""

    def __init__(self) -> None:
        self.now = 50.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


class FakeCamera:
    """A camera with a script: until which time it is "fine", "dropping", "broken" or "unplugged".

    At "interrupted" somebody presses Ctrl-C. It stands for all `cv2.VideoCapture` of one device.
    """

    def __init__(self, clock: Clock, *script: tuple[float, str]) -> None:
        self.clock, self.script, self.start = clock, script, clock.now
        self.opened = self.released = 0
        self.size = (HEIGHT, WIDTH)

    @property
    def state(self) -> str:
        passed = self.clock.now - self.start
        return next((state for until, state in self.script if passed < until), "unplugged")

    def open(self, index: int) -> Any:
        if self.state == "unplugged":
            return None
        self.opened += 1
        return self

    def read(self) -> tuple[bool, ByteImage | None]:
        if self.state == "interrupted":
            raise KeyboardInterrupt
        if self.state == "broken":
            import cv2

            raise cv2.error("the device is gone")
        if self.state != "fine":
            return False, None
        self.clock.sleep(PERIOD)
        return True, np.zeros((*self.size, 3), dtype=np.uint8)

    def release(self) -> None:
        self.released += 1


class Everywhere(ToldDetector):
    """Sees one face, a metre away, in every picture."""

    def detect(self, bgr: ByteImage, t: float) -> list[SeenFace]:
        super().detect(bgr, t)
        return [seen(1, face_at(0, 0, 1))]
