"""From frames of a person to observations: distance, speed, gaze, smile, gestures."""

from kendon.features.gaze import eye_gaze, head_gaze
from kendon.features.proxemics import closing_speed, distance
from kendon.features.sampler import PERIOD, ROBOT_FACE, Sampler
from kendon.features.smile import smile
from kendon.features.track import observe

__all__ = [
    "PERIOD",
    "ROBOT_FACE",
    "Sampler",
    "closing_speed",
    "distance",
    "eye_gaze",
    "head_gaze",
    "observe",
    "smile",
]
