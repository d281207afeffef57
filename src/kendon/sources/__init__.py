"""Where people come from: files, devices and the simulation, each a thin adapter."""

from kendon.sources.avdiar import AvdiarSource, read_avdiar_pairs
from kendon.sources.bags import BagSource, read_bag, read_bag_people
from kendon.sources.base import (
    CameraMount,
    Source,
    SourceOptions,
    find_source,
    open_source,
    recordings,
    registered_sources,
)
from kendon.sources.camera import CameraSource
from kendon.sources.isr_uol import IsrUolSource, read_isr_uol_pairs
from kendon.sources.openface import OpenFaceSource, read_openface
from kendon.sources.recording import RecordedSource, TrackSource
from kendon.sources.simulated import SimulatedSource
from kendon.sources.uol import UolSource, read_uol_pairs
from kendon.sources.video import VideoSource

__all__ = [
    "AvdiarSource",
    "BagSource",
    "CameraMount",
    "CameraSource",
    "IsrUolSource",
    "OpenFaceSource",
    "RecordedSource",
    "SimulatedSource",
    "Source",
    "SourceOptions",
    "TrackSource",
    "UolSource",
    "VideoSource",
    "find_source",
    "open_source",
    "read_avdiar_pairs",
    "read_bag",
    "read_bag_people",
    "read_isr_uol_pairs",
    "read_openface",
    "read_uol_pairs",
    "recordings",
    "registered_sources",
]
