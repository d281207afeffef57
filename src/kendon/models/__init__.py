"""From observations to beliefs: hidden Markov models of a greeting."""

from kendon.models.assignment import Assignment
from kendon.models.emissions import Emissions, Family
from kendon.models.greeting import Belief, GreetingModel, Tracker
from kendon.models.hmmlearn_models import from_hmmlearn, name_states, to_hmmlearn
from kendon.models.learning import Fit, fit
from kendon.models.library import DEFAULT_MODEL, load_model, model_names, save_model
from kendon.models.prior import Prior
from kendon.models.sampling import sample

__all__ = [
    "DEFAULT_MODEL",
    "Assignment",
    "Belief",
    "Emissions",
    "Family",
    "Fit",
    "GreetingModel",
    "Prior",
    "Tracker",
    "fit",
    "from_hmmlearn",
    "load_model",
    "model_names",
    "name_states",
    "sample",
    "save_model",
    "to_hmmlearn",
]
