"""The encounter under a page: its time, its past, and how much of it is kept."""

from __future__ import annotations

import gc
from dataclasses import replace

import pytest
from viewer.browser import encounters

from kendon.errors import ParameterError
from kendon.greeter import Greeter
from kendon.robots import PointRobot
from kendon.trees import TICK_RATE
from kendon.viewer.browser import stage as stages
from kendon.viewer.browser.played import PlayedSource
from kendon.viewer.browser.player import Player
from kendon.viewer.browser.session import Choices, Session
from kendon.viewer.browser.stage import NODE_STATES, Stage


def test_ten_minutes_leave_no_more_behind_than_five() -> None:
    player = Player(rate=10.0)
    robot = PointRobot()
    stage = Stage(Greeter(PlayedSource(player), robot=robot), history=60.0)

    def live(minutes: float) -> int:
        for tick in range(round(minutes * 60 * TICK_RATE)):
            if tick % 50 == 0:  # restless: back and forth, and waving
                player.walk_up(1.2 if tick % 100 else 5.0)
                player.act("wave", robot.pose)
            stage.advance()
        gc.collect()
        return len(gc.get_objects())

    # What is kept for a while has filled up after some minutes.
    early = live(7.0)
    late = live(3.0)
    assert stage.now == pytest.approx(600.0)
    assert len(stage.snapshots) == 60 * TICK_RATE
    assert len(stage.actions) == stages.COMMANDS
    assert len(robot.log) <= stages._LOG + 10
    assert late < early * 1.02


def test_time_runs_at_the_chosen_speed_and_stands_still_in_a_pause() -> None:
    session = encounters.played()
    begun = session.stage.now
    encounters.pass_time(session, 1.0)
    assert session.stage.now - begun == pytest.approx(1.0)
    session.hurry(2.0)
    encounters.pass_time(session, 1.0)
    assert session.stage.now - begun == pytest.approx(3.0)
    session.pause()
    encounters.pass_time(session, 1.0)
    assert session.stage.now - begun == pytest.approx(3.0)
    session.resume()
    session.hurry(0.5)
    encounters.pass_time(session, 1.0)
    assert session.stage.now - begun == pytest.approx(3.5)
    with pytest.raises(ParameterError, match="the speed is one of"):
        session.hurry(7.0)


def test_the_past_can_be_looked_at_and_left_again() -> None:
    session = encounters.simulated()
    encounters.pass_time(session, 5.0)
    now = session.stage.now
    session.look_back(2.0)
    assert session.looking_back
    assert session.shown().snapshot.t == pytest.approx(2.0)
    encounters.pass_time(session, 1.0)
    assert session.shown().snapshot.t == pytest.approx(2.0)
    session.resume()
    encounters.pass_time(session, 0.5)
    assert not session.looking_back
    assert session.stage.now == pytest.approx(now + 0.5)
    session.look_back(1e9)
    assert not session.looking_back


def test_an_encounter_that_is_over_can_be_played_again() -> None:
    session = encounters.simulated("simulated:short")
    session.hurry(4.0)
    encounters.pass_time(session, 20.0)
    assert session.stage.over
    assert session.paused
    length = session.stage.now
    session.resume()
    encounters.pass_time(session, 0.5)
    assert session.shown().snapshot.t == pytest.approx(2.1, abs=0.15)
    encounters.pass_time(session, length)
    assert session.paused
    assert session.shown().snapshot.t == length


def test_starting_anew_takes_other_choices_or_says_why_not() -> None:
    session = encounters.simulated()
    encounters.pass_time(session, 3.0)
    session.restart(source="simulated:short", model="data-driven")
    assert session.choices == Choices("simulated:short", "data-driven", "point")
    assert session.stage.now < 0.2
    session.restart(model="nonsense")
    assert "there is no" in session.trouble
    assert session.choices.model == "data-driven"
    session.restart()
    assert session.trouble == ""


def test_what_others_want_is_done_by_the_next_step() -> None:
    session = encounters.played()
    done = []
    session.post(lambda: done.append(1))
    assert done == []
    session.step(0.0)
    assert done == [1]


def test_between_two_ticks_the_robot_is_drawn_on_its_way() -> None:
    session = encounters.simulated()
    encounters.pass_time(session, 3.5)
    stage, place = session.stage, session.place
    a, b = stage.snapshots[place - 1].robot, stage.snapshots[place].robot
    half = stage.shown(place, 0.5).robot
    assert half[:2] == pytest.approx((a[:2] + b[:2]) / 2)
    # Past the half-turn a heading goes the short way.
    left, right = a.copy(), a.copy()
    left[2], right[2] = 3.1, -3.1
    assert abs(stage.form.between(left, right, 0.5)[2]) == pytest.approx(3.1416, abs=1e-3)


def test_a_snapshot_knows_every_node_of_the_tree() -> None:
    session = encounters.simulated()
    encounters.pass_time(session, 4.0)
    stage = session.stage
    assert stage.nodes[0].parent == -1
    assert all(-1 < node.parent < place for place, node in enumerate(stage.nodes) if place)
    assert [n.depth for n in stage.nodes[:2]] == [0, 1]
    snapshot = stage.snapshots[-1]
    assert len(snapshot.nodes) == len(stage.nodes)
    assert NODE_STATES[snapshot.nodes[0]] != "idle"


def test_a_stage_hands_on_the_moments_of_its_flow() -> None:
    stage, _ = encounters.make(Choices("simulated:short", "kendon", "point"))
    moments = list(stage.run())
    assert [m.t for m in moments] == [s.t for s in stage.snapshots]
    assert stage.over


def test_a_session_closes_a_device_before_it_opens_it_again() -> None:
    class Device(PlayedSource):
        live = True

    order: list[str] = []

    def make(choices: Choices) -> tuple[Stage, Player | None]:
        order.append("open")
        player = Player()
        stage = Stage(Greeter(Device(player), robot=PointRobot()))
        close = stage.close

        def told() -> None:
            order.append("close")
            close()

        stage.close = told  # type: ignore[method-assign]
        return stage, player

    session = Session(make, replace(Choices("device", "kendon", "point")))
    session.restart()
    assert order[:3] == ["open", "close", "open"]


@pytest.mark.parametrize("spec", ["simulated", "simulated:late-wave", "simulated:shy"])
def test_every_built_in_person_has_a_page_to_be_chosen_on(spec: str) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    from kendon.viewer.browser.server import Page

    session = encounters.simulated(spec)
    Page(session, lambda: "", port=0).close()
    assert session.stage.over
