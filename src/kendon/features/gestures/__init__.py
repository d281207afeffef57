"""Gestures of a greeting, detected from a person's joints and head (thesis 3.3.5)."""

from kendon.features.gestures.detector import READ_BACK, Evidence, GestureDetector, Gestures
from kendon.features.gestures.track import Question, feed

__all__ = ["READ_BACK", "Evidence", "GestureDetector", "Gestures", "Question", "feed"]
