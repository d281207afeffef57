"""From observations to beliefs: hidden Markov models of a greeting."""

from kendon.models.emissions import Emissions, Family
from kendon.models.greeting import Belief, GreetingModel, Tracker
from kendon.models.library import DEFAULT_MODEL, load_model, model_names, save_model

__all__ = [
    "DEFAULT_MODEL",
    "Belief",
    "Emissions",
    "Family",
    "GreetingModel",
    "Tracker",
    "load_model",
    "model_names",
    "save_model",
]
