"""Sources that hold a whole recording in memory, and the one that reads kendon's own track CSV."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Self

from kendon.person import PersonFrame, Track
from kendon.sources.base import Source, SourceOptions, register
from kendon.tables import peek_header
from kendon.tracks import read_track


class RecordedSource(Source):
    """A source whose whole track is known before the first frame is asked for.

    `Greeter(RecordedSource(track))` greets the person of a track in memory.
    """

    def __init__(self, track: Track) -> None:
        self.track = track

    def frames(self) -> Iterator[PersonFrame]:
        """The frames of the track."""
        return iter(self.track)

    def record(self, progress: Callable[[PersonFrame], None] | None = None) -> Track:
        """The track itself."""
        del progress  # there is nothing to wait for
        return self.track

    def with_gestures_from_phases(self) -> Self:
        """The same recording as if the thesis's keys had been pressed by its true phases.

        Raises:
            ParameterError: it has none.
        """
        changed = copy.copy(self)
        changed.track = self.track.with_gestures_from_phases()
        return changed


@register
class TrackSource(RecordedSource):
    """One person over time in kendon's track CSV (see `kendon.tracks`)."""

    name = "track"
    reads = "kendon's track CSV: t, head_x, head_y, head_z and more"
    example = "person.csv"

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """A .csv file with a column ``t`` and one for the head."""
        header = peek_header(spec) if Path(spec).suffix.lower() == ".csv" else ()
        return "t" in header and any(column.startswith("head_") for column in header)

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> TrackSource:
        """Read the file; the options do not matter, a track is in the robot's frame already.

        Raises:
            DataError: see `kendon.tracks.read_track`.
        """
        return cls(read_track(spec))
