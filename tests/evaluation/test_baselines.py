"""The baselines on tracks whose phases can be told by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evaluation_data import numbers, pass_by, stamps, walk_up
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kendon.estimate import stretches
from kendon.evaluation import BASELINES, EngagementZones, ProxemicStateMachine, Reader
from kendon.observations import Observations
from kendon.person import FloatArray
from kendon.phases import Phase

NAN = float("nan")


def observed(distance: list[float], speed: list[float]) -> Observations:
    values = np.full((len(distance), 7), np.nan)
    values[:, 0], values[:, 1] = distance, speed
    return Observations(stamps(len(distance)), values)


def test_the_state_machine_goes_through_its_five_states() -> None:
    greeting = walk_up("ann", start=6.0)
    read = ProxemicStateMachine().read(greeting)
    order = [part.number for part in stretches(read)]
    assert order == [Phase.IA, Phase.DS, Phase.APP, Phase.FA, Phase.CS]
    # Sets off at 1.2 s; the salutation lasts 1.2 s; 1.2 m are crossed one row before the end.
    assert (read[:5] == Phase.IA).all()
    assert (read[5:11] == Phase.DS).all()
    distance = greeting.values[:, 0]
    assert read[np.argmax(distance < 1.2)] == Phase.FA
    assert read[-1] == Phase.CS


def test_the_state_machine_never_goes_back_and_changes_once_an_observation() -> None:
    read = ProxemicStateMachine().read(
        observed([0.5, 0.5, 0.5, 0.5, 5.0, 5.0], [1.0, 0.0, 0.0, 0.0, 1.0, -1.0])
    )
    np.testing.assert_array_equal(read, numbers("DAFCCC"))


def test_a_person_who_stands_still_stays_in_initiation_of_approach() -> None:
    read = ProxemicStateMachine().read(observed([0.9] * 6, [0.1] * 6))
    np.testing.assert_array_equal(read, numbers("IIIIII"))


def test_zones_by_hand() -> None:
    distance = [NAN, 4.0, 2.5, 2.49, NAN, 1.5, 1.49, NAN, 3.0]
    read = EngagementZones().read(observed(distance, [NAN] * 9))
    np.testing.assert_array_equal(read, numbers("IAAFFFCCA"))


def test_a_machine_that_sees_nothing_keeps_its_state() -> None:
    greeting = walk_up("ann")
    values = greeting.values.copy()
    values[8:] = np.nan
    read = ProxemicStateMachine().read(replace(greeting, values=values))
    # The salutation ends by its time; without a distance nothing further happens.
    assert (read[8:11] == Phase.DS).all()
    assert (read[11:] == Phase.APP).all()


@pytest.mark.parametrize("reader", BASELINES, ids=lambda reader: str(reader.name))
@given(
    values=arrays(
        float, (12, 7), elements=st.one_of(st.just(NAN), st.floats(0, 8, allow_nan=False))
    ),
    cut=st.integers(1, 11),
)
def test_baselines_are_causal_and_read_a_phase_in_every_row(
    reader: Reader, values: FloatArray, cut: int
) -> None:
    whole = Observations(stamps(12), values)
    part = Observations(whole.t[:cut], values[:cut])
    read = reader.read(whole)
    assert read.shape == (12,)
    assert set(read.tolist()) <= set(Phase)
    assert reader.causal
    np.testing.assert_array_equal(reader.read(part), read[:cut])


@pytest.mark.parametrize("reader", BASELINES, ids=lambda reader: str(reader.name))
def test_baselines_mind_nothing_but_distance_and_speed(reader: Reader) -> None:
    person = pass_by("bob")
    values = person.values.copy()
    values[:, 2:] = np.nan
    np.testing.assert_array_equal(reader.read(person), reader.read(replace(person, values=values)))
