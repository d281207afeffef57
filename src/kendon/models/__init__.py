"""From observations to beliefs: hidden Markov models of a greeting."""

from kendon.models.greeting import Belief, GreetingModel, Tracker
from kendon.models.library import DEFAULT_MODEL, load_model, model_names

__all__ = ["DEFAULT_MODEL", "Belief", "GreetingModel", "Tracker", "load_model", "model_names"]
