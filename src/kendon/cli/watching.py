"""How `kendon estimate` reads a source: as it happens, with an overlay, until it is enough."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from kendon.errors import ParameterError
from kendon.geometry import Vec3
from kendon.models import GreetingModel
from kendon.person import PersonFrame, Track
from kendon.sources import Source
from kendon.sources.pictures import PictureSource
from kendon.viewer.overlay import OverlayVideo, check_overlay
from kendon.watch import Watch


@dataclass(frozen=True)
class Watching:
    """What the user asks of the reading.

    Raises:
        ParameterError: it is asked to last no time.
        DataError: the overlay has an ending or a folder that cannot be.
    """

    model: GreetingModel
    face: Vec3  # the robot's, in its base frame [m]
    seconds: float | None = None  # to read at most, of the source's own time
    overlay: Path | None = None  # a video to draw

    def __post_init__(self) -> None:
        if self.seconds is not None and not 0 < self.seconds < math.inf:
            raise ParameterError(f"--seconds is more than 0, not {self.seconds:g}")
        if self.overlay is not None:
            check_overlay(self.overlay)

    def record(
        self,
        source: Source,
        progress: Callable[[PersonFrame], None],
        tell: Callable[[str], None],
    ) -> Track:
        """A source's frames as a track.

        Args:
            source: a person, opened.
            progress: called after each frame.
            tell: called with each sentence for the user, when it is known.

        A live source ends with Ctrl-C, and what was read until then counts.

        Raises:
            ParameterError: an overlay is asked for, but the source has no pictures.
            DataError: there is something wrong with what the source reads.
        """
        pictures = source if isinstance(source, PictureSource) else None
        if self.overlay is not None and pictures is None:
            raise ParameterError(
                f"--overlay draws on pictures, and the source {source.name} has none; it is for"
                " videos and cameras"
            )
        if pictures is None and not source.live:
            if self.seconds is not None:
                raise ParameterError("--seconds is for videos and for what is live")
            for sentence in source.notes:
                tell(sentence)
            return source.record(progress)  # with all that a recording knows, such as phases
        if source.live and self.seconds is None:
            tell("reading until Ctrl-C; --seconds N ends by itself")
        watch = Watch(source, self.model, self.face)
        told = len(source.notes)
        for sentence in source.notes:
            tell(sentence)
        with ExitStack() as stack:
            video = None
            if self.overlay is not None and pictures is not None:
                video = stack.enter_context(OverlayVideo(self.overlay, pictures.rate, self.face))
            try:
                for watched in watch.run(self.seconds):
                    progress(watched.frame)
                    if video is not None:
                        video.add(watched)
                    for sentence in source.notes[told:]:
                        tell(sentence)
                    told = len(source.notes)
            except KeyboardInterrupt:
                if not source.live:
                    raise
                tell("stopped; what was read until then counts")
        for sentence in source.notes[told:]:
            tell(sentence)
        if latency := watch.latency:
            tell(
                f"from picture to belief: {1000 * latency.median:.0f} ms in the median, 95 % within"
                f" {1000 * latency.high:.0f} ms"
            )
        return watch.track
