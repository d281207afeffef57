"""Who is greeted, and for how long."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from kendon.sources.face_choice import INSISTENCE, NEARER, PATIENCE, Candidate, GreetedChoice

NEAR_AWAY = Candidate(1, 1.5, facing=False)
FAR_FACING = Candidate(2, 3.0, facing=True)
FARTHER_FACING = Candidate(3, 4.0, facing=True)


def test_the_nearest_who_faces_the_robot_comes_first() -> None:
    people = [NEAR_AWAY, FARTHER_FACING, FAR_FACING]
    assert GreetedChoice().choose(people, 0.0) == 2


def test_if_nobody_faces_it_the_nearest_does() -> None:
    assert GreetedChoice().choose([Candidate(4, 3.0, facing=False), NEAR_AWAY], 0.0) == 1
    assert GreetedChoice().choose([], 0.0) is None


def test_somebody_nearer_does_not_push_in_while_the_greeted_one_looks() -> None:
    choice = GreetedChoice()
    choice.choose([FAR_FACING], 0.0)
    for i in range(100):
        assert choice.choose([Candidate(5, 0.8, facing=True), FAR_FACING], i / 10) == 2


def test_looking_away_alone_loses_nobody() -> None:
    choice = GreetedChoice()
    choice.choose([FAR_FACING], 0.0)
    away = Candidate(2, 3.0, facing=False)
    beside = Candidate(5, 3.0 - NEARER + 0.01, facing=True)
    assert all(choice.choose([away, beside], i / 10) == 2 for i in range(100))


def test_who_insists_nearer_and_facing_is_greeted_in_the_end() -> None:
    choice = GreetedChoice()
    choice.choose([FAR_FACING], 0.0)
    away, near = Candidate(2, 3.0, facing=False), Candidate(5, 1.0, facing=True)
    chosen = [choice.choose([away, near], 1 + i / 10) for i in range(40)]
    change = chosen.index(5)
    assert 10 * INSISTENCE <= change <= 10 * INSISTENCE + 1
    assert set(chosen[change:]) == {5}


def test_one_look_of_the_greeted_one_makes_the_rival_start_anew() -> None:
    choice = GreetedChoice()
    choice.choose([FAR_FACING], 0.0)
    away, near = Candidate(2, 3.0, facing=False), Candidate(5, 1.0, facing=True)
    for i in range(100):
        greeted = FAR_FACING if i % 15 == 0 else away
        assert choice.choose([greeted, near], i / 10) == 2


def test_a_short_loss_is_waited_for_and_a_long_one_is_not() -> None:
    choice = GreetedChoice()
    choice.choose([FAR_FACING], 0.0)
    assert choice.choose([FARTHER_FACING], PATIENCE - 0.1) is None
    assert choice.choose([FARTHER_FACING, FAR_FACING], PATIENCE) == 2
    assert choice.choose([FARTHER_FACING], 2 * PATIENCE + 0.1) == 3


def test_the_one_asked_for_is_the_only_one() -> None:
    choice = GreetedChoice(only=3)
    assert choice.choose([NEAR_AWAY, FAR_FACING], 0.0) is None
    assert choice.choose([NEAR_AWAY, FARTHER_FACING], 99.0) == 3


@given(
    st.lists(
        st.lists(st.tuples(st.integers(1, 4), st.floats(0.5, 5), st.booleans()), max_size=4),
        max_size=60,
    )
)
def test_only_who_is_there_is_ever_greeted(
    pictures: list[list[tuple[int, float, bool]]],
) -> None:
    choice = GreetedChoice()
    for i, picture in enumerate(pictures):
        people = list({number: Candidate(number, d, f) for number, d, f in picture}.values())
        chosen = choice.choose(people, i / 5)
        assert chosen is None or chosen in {person.number for person in people}
