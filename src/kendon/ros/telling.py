"""What kendon tells on topics: the state, the belief and the observation after each interval."""

from __future__ import annotations

from typing import Any

from kendon.models import Belief
from kendon.observations import FEATURES, Observation
from kendon.phases import Phase


def fill_belief(message: Any, belief: Belief) -> Any:
    """Write a belief into a ``kendon_msgs/Belief``, except its header; return it."""
    message.phase = belief.phase.value
    message.probabilities = belief.probabilities.tolist()
    return message


def fill_observation(message: Any, observation: Observation) -> Any:
    """Write an observation into a ``kendon_msgs/Observation``, except its header; return it."""
    for name in FEATURES:
        setattr(message, name, getattr(observation, name))
    return message


def fill_state(message: Any, phase: Phase) -> Any:
    """Write the phase's number (thesis 4.1.1) into a String or an integer message; return it."""
    message.data = str(phase.value) if isinstance(message.data, str) else phase.value
    return message


def phase_of_state(message: Any) -> Phase:
    """The phase that a message of ``/state`` tells, by its number or its name.

    Raises:
        UnknownNameError: it tells none.
    """
    return Phase.parse(str(message.data))
