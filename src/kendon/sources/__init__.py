"""Where people come from: files, devices and the simulation, each a thin adapter."""

from kendon.sources.base import (
    CameraMount,
    Source,
    SourceOptions,
    find_source,
    open_source,
    registered_sources,
)
from kendon.sources.openface import OpenFaceSource, read_openface
from kendon.sources.recording import RecordedSource, TrackSource
from kendon.sources.simulated import SimulatedSource
from kendon.sources.video import CameraSource, VideoSource

__all__ = [
    "CameraMount",
    "CameraSource",
    "OpenFaceSource",
    "RecordedSource",
    "SimulatedSource",
    "Source",
    "SourceOptions",
    "TrackSource",
    "VideoSource",
    "find_source",
    "open_source",
    "read_openface",
    "registered_sources",
]
