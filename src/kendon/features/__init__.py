"""From frames of a person to observations: distance, speed, gaze, smile, gestures."""

from kendon.features.gaze_of_track import eye_gaze, head_gaze
from kendon.features.proxemics import closing_speed, distance
from kendon.features.sampler import PERIOD, ROBOT_FACE, Sampler
from kendon.features.smile import smile
from kendon.features.track import observe, observe_all

__all__ = [
    "PERIOD",
    "ROBOT_FACE",
    "Sampler",
    "closing_speed",
    "distance",
    "eye_gaze",
    "head_gaze",
    "observe",
    "observe_all",
    "smile",
]
