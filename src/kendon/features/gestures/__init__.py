"""Gestures of a greeting, detected from a person's joints and head (thesis 3.3.5)."""

from kendon.features.gestures.detector import GestureDetector, Gestures
from kendon.features.gestures.track import gesture_rows

__all__ = ["GestureDetector", "Gestures", "gesture_rows"]
