"""Many simulated greeters at once, as sets of observations."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum

import numpy as np

from kendon.errors import ParameterError
from kendon.features import observe_all
from kendon.observations import Observations
from kendon.person import Track
from kendon.processes import each
from kendon.simulation.greeters import draw_greeter, draw_passerby, perform
from kendon.simulation.sensors import SENSORS, Sensor, draw_sensor

#: So many greetings are observed at once, in one call of a worker.
_BATCH = 100


class Seeing(StrEnum):
    """Through what sensors the people of a set are seen."""

    CLEAN = "clean"  # as they are
    NOISY = "noisy"  # through one bad sensor
    VARIED = "varied"  # some as they are, some through a sensor drawn for each


class Signs(StrEnum):
    """How the gestures of a set's people become known."""

    KEYS = "keys"  # pressed by the true phases (thesis 3.3.5)
    BODIES = "bodies"  # people move their bodies, and the detectors see what they can
    VARIED = "varied"  # half of the people each


#: The share of a varied set that is seen through a drawn sensor.
SENSED_SHARE = 0.4


def simulate(
    n: int,
    seed: int = 0,
    *,
    seeing: Seeing = Seeing.CLEAN,
    signs: Signs = Signs.KEYS,
    passersby: float = 0.0,
    jobs: int = 1,
    progress: Callable[[int], None] | None = None,
) -> list[Observations]:
    """Draw people and observe them.

    The same seed gives the same people, in whatever number of jobs and however many follow.

    Args:
        n: how many.
        seed: of chance, not negative.
        seeing: through what sensors.
        signs: how gestures become known.
        passersby: the share of people who only walk past (true phases 0).
        jobs: processes at work; -1 for one on each core.
        progress: called with the number of people done after each batch.

    Returns:
        One entry a person, named ``greeting_00000`` or ``passerby_00000`` and on.

    Raises:
        ParameterError: n, seed or the share is out of range.
    """
    if n < 1 or seed < 0:
        raise ParameterError(
            f"simulate at least one person, with a seed from 0 on: not {n}, {seed}"
        )
    if not 0 <= passersby <= 1:
        raise ParameterError(f"the share of passers-by lies between 0 and 1, not {passersby}")
    batches = (
        (start, min(start + _BATCH, n), seed, seeing, signs, passersby)
        for start in range(0, n, _BATCH)
    )
    done: list[Observations] = []
    for batch in each(_batch, batches, jobs):
        done += batch
        if progress:
            progress(len(done))
    return done


def _batch(
    start: int, stop: int, seed: int, seeing: Seeing, signs: Signs, passersby: float
) -> list[Observations]:
    people = range(start, stop)
    return observe_all([_person(number, seed, seeing, signs, passersby) for number in people])


def _person(number: int, seed: int, seeing: Seeing, signs: Signs, passersby: float) -> Track:
    rng = np.random.default_rng([seed, number])
    joints = signs is Signs.BODIES or (signs is Signs.VARIED and number % 2 == 1)
    if rng.random() < passersby:
        track = draw_passerby(rng, f"passerby_{number:05d}", joints=joints)
    else:
        track = perform(draw_greeter(rng), rng, f"greeting_{number:05d}", joints=joints)
    sensor: Sensor | None = None
    if seeing is Seeing.NOISY:
        sensor = SENSORS["noisy"]
    elif seeing is Seeing.VARIED and rng.random() < SENSED_SHARE:
        sensor = draw_sensor(rng)
    return sensor.see(track, rng) if sensor else track
