"""Readers without a model, for a model to be better than.

Both know distance and speed only, keep their state where these are unknown, and are causal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kendon.observations import FEATURES, Observations
from kendon.person import IntArray
from kendon.phases import Phase

_DISTANCE = FEATURES.index("distance")


@dataclass(frozen=True)
class ProxemicStateMachine:
    """The state machine of Heenan et al.'s Nao, turned round to read a person (thesis 2.4).

    Their robot went through IA, DS, APP, FA and CS, always in this order and never back, without
    a Head Dip, moved by where the two stood. Read from a person, each state lasts until:

    - IA: the person sets off. The machine takes everyone who comes near to have been greeted.
    - DS: the salutation is over, or the person is within personal distance already.
    - APP: the person enters personal distance, 1.2 m, where that robot turned its head to the
      person (thesis 2.4, *Final Approach*; Hall 1966).
    - FA: the person stands still.
    - CS: for good.

    It changes by one state an observation, as that machine could not skip one.
    """

    name: str = "state machine"
    causal: bool = True
    #: [m], Hall's personal distance
    personal_distance: float = 1.2
    #: [m/s], faster is walking: half way from standing to a slow walk of 0.8, which is
    #: one deviation below the 1.2 of thesis 3.4
    walking_speed: float = 0.4
    #: [s], how long a wave takes, the salutation of their robot
    salutation: float = 1.2

    def read(self, observations: Observations) -> IntArray:
        """The phases 1-6, shape (T,)."""
        state, since = Phase.IA, 0.0
        phases = np.empty(len(observations), dtype=np.int64)
        for row, seen in enumerate(observations):
            # Comparisons with NaN are false: what is unknown moves nothing.
            near = seen.distance < self.personal_distance
            follower = {
                Phase.IA: Phase.DS if seen.speed >= self.walking_speed else None,
                Phase.DS: Phase.APP if near or self._over(seen.t - since) else None,
                Phase.APP: Phase.FA if near else None,
                Phase.FA: Phase.CS if seen.speed < self.walking_speed else None,
            }.get(state)
            if follower is not None:
                state, since = follower, seen.t
            phases[row] = state
        return phases

    def _over(self, lasted: float) -> bool:
        return lasted >= self.salutation - 1e-6  # stamps are rounded


@dataclass(frozen=True)
class EngagementZones:
    """Zones around the robot: the phase that most often happens at such a distance.

    The nearer border, 1.5 m, is where the final approach ends and close salutations take place
    (thesis 3.4); the farther one, 2.5 m, is where robots that mind nothing but distance commonly
    take a person for engaged, inside the 3 m at which the final approach begins. Beyond it people
    approach. Before a distance is known, the person has only just been sighted.
    """

    name: str = "zones"
    causal: bool = True
    near: float = 1.5  # [m], within it CS
    far: float = 2.5  # [m], within it FA, beyond it APP

    def read(self, observations: Observations) -> IntArray:
        """The phases 1-6, shape (T,)."""
        distance = observations.values[:, _DISTANCE]
        zone = np.select(
            [distance < self.near, distance < self.far, np.isfinite(distance)],
            [Phase.CS, Phase.FA, Phase.APP],
            default=0,
        )
        # The last row with a known zone, for each row.
        last = np.maximum.accumulate(np.where(zone > 0, np.arange(len(zone)), -1))
        return np.where(last >= 0, zone[last], Phase.IA).astype(np.int64)


#: What every comparison contains.
BASELINES = (ProxemicStateMachine(), EngagementZones())
