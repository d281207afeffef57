"""The whole flow: a person in, phases and a robot's commands out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from kendon import Encounter, Greeter, Moment, PointRobot, open_source
from kendon.errors import DataError, ParameterError
from kendon.geometry import Pose2D
from kendon.greeter import FORGOTTEN, REMEMBERED, Action, describe
from kendon.person import PersonFrame, Track
from kendon.phases import Phase
from kendon.robots.base import CommandKind, CommandStatus
from kendon.robots.point import GESTURE_SECONDS
from kendon.simulation import SCRIPTS, SimulatedPerson
from kendon.sources import RecordedSource, Source, SourceOptions

IN_ORDER = [Phase.IA, Phase.APP, Phase.DS, Phase.HD, Phase.APP, Phase.FA, Phase.CS]
SALUTATIONS = {"wave", "handshake"}


class Frames(Source):
    """A recorded person: whatever frames it is given; an exception among them is raised."""

    def __init__(self, frames: Iterable[PersonFrame | Exception]) -> None:
        self.given = list(frames)

    def frames(self) -> Iterator[PersonFrame]:
        for frame in self.given:
            if isinstance(frame, Exception):
                raise frame
            yield frame


def recorded(start: float = 0.0) -> list[PersonFrame]:
    """The frames of the normal greeting as before a robot that stands still."""
    person, frames = SimulatedPerson(SCRIPTS["normal"]), []
    while not person.finished:
        frames.append(person.frame()._replace(t=start + person.t))
        person.step()
    return frames


def encounter(greeter: Greeter) -> Encounter:
    record = Encounter()
    for moment in greeter.run():
        record.add(moment)
    return record


def same(here: Moment, there: Moment) -> bool:
    """Whether two moments of two runs are the same, unknown numbers and all."""

    def text(m: Moment) -> str:
        belief = None if m.belief is None else m.belief.probabilities.tolist()
        commands = [(c.kind, c.asked, c.issued, c.sent) for c in m.commands]
        return repr((m.t, m.person, m.observation, belief, m.is_new, m.robot, commands))

    return text(here) == text(there)


@pytest.fixture(scope="module")
def normal() -> tuple[Greeter, Encounter]:
    greeter = Greeter(open_source("simulated:normal"))
    return greeter, encounter(greeter)


def visits(record: Encounter) -> list[tuple[Phase, list[Action]]]:
    """The actions, visit by visit of a phase."""
    found: list[tuple[Phase, list[Action]]] = []
    for action in record.actions:
        assert action.phase is not None
        if not found or found[-1][0] is not action.phase:
            found.append((action.phase, []))
        found[-1][1].append(action)
    return found


# ---- the normal greeting


def test_the_phases_of_a_normal_greeting_are_read_in_order(
    normal: tuple[Greeter, Encounter],
) -> None:
    assert normal[1].phases == IN_ORDER


def test_each_phase_is_answered_as_chapter_4_prescribes(normal: tuple[Greeter, Encounter]) -> None:
    face, dip = "look 1.6 m high", "look 0.8 m high"  # the face, and half its height
    prescribed = {
        Phase.IA: ({"turn", face}, {"neutral"}),
        Phase.DS: ({"wave", face}, {"smile"}),
        # Arms go home in these three, once the wave is over. It turns once it is near enough.
        Phase.HD: ({dip}, {"home", "neutral"}),
        Phase.APP: ({"drive", dip}, {"home", "neutral"}),
        Phase.FA: ({"drive", face}, {"home", "smile", "turn"}),
        Phase.CS: ({"handshake", "“Pleased to meet you”", face}, {"smile"}),
    }
    answers = visits(normal[1])
    assert [phase for phase, _ in answers] == IN_ORDER
    for phase, actions in answers:
        labels = {action.label for action in actions}
        needed, allowed = prescribed[phase]
        assert needed <= labels <= needed | allowed, phase


def test_the_robot_turns_to_the_person_before_it_looks(normal: tuple[Greeter, Encounter]) -> None:
    _, actions = visits(normal[1])[0]
    turn = next(a for a in actions if a.label == "turn")
    look = next(a for a in actions if a.channel == "head")
    assert turn.command.status is CommandStatus.SUCCEEDED
    assert turn.command.asked["yaw"] == pytest.approx(SCRIPTS["normal"].bearing, abs=1e-6)
    assert turn.end <= look.start


def test_approaches_end_a_metre_in_front_of_the_person(normal: tuple[Greeter, Encounter]) -> None:
    for moment in normal[1].moments:
        for command in moment.commands:
            if command.kind is CommandKind.GO_TO:
                assert moment.person is not None
                x, y, _ = moment.robot.to_world(moment.person.head)
                assert command.asked["goal"].distance_to(Pose2D(x, y, 0)) == pytest.approx(1.0)
    last = normal[1].moments[-1].person
    assert last is not None
    assert math.hypot(last.head[0], last.head[1]) == pytest.approx(1.0, abs=0.1)


def test_one_wave_one_handshake_one_sentence(normal: tuple[Greeter, Encounter]) -> None:
    labels = [action.label for action in normal[1].actions]
    assert [labels.count(label) for label in ("wave", "handshake")] == [1, 1]
    assert [a.channel for a in normal[1].actions].count("voice") == 1


def test_a_wave_is_finished_and_then_the_arms_go_home(normal: tuple[Greeter, Encounter]) -> None:
    wave = next(a for a in normal[1].actions if a.label == "wave")
    home = next(a for a in normal[1].actions if a.label == "home" and a.start >= wave.start)
    assert wave.command.status is CommandStatus.SUCCEEDED
    assert wave.end - wave.start == pytest.approx(GESTURE_SECONDS["wave"])
    assert wave.end <= home.start <= wave.end + 0.11


def test_what_else_a_phase_started_is_cancelled_when_the_phase_changes(
    normal: tuple[Greeter, Encounter],
) -> None:
    for (phase, actions), (_, following) in pairwise(visits(normal[1])):
        for action in actions:
            # A face keeps its expression and arms finish; all else is over by the next answer.
            if action.channel not in ("face", "arms"):
                assert action.end <= following[0].start, (phase, action.label)


def test_moments_are_a_tick_apart_and_say_when_an_observation_is_new(
    normal: tuple[Greeter, Encounter],
) -> None:
    moments = normal[1].moments
    np.testing.assert_allclose([m.t for m in moments], 0.1 * np.arange(1, len(moments) + 1))
    new = [m for m in moments if m.is_new]
    assert moments[0].observation is None
    assert moments[0].belief is None
    np.testing.assert_allclose([m.t for m in new], 0.2 * np.arange(1, len(new) + 1))
    for moment in new:
        assert moment.observation is not None
        assert moment.observation.t == pytest.approx(moment.t)


def test_moments_hold_every_command_of_the_robots_log_but_the_last_stop(
    normal: tuple[Greeter, Encounter],
) -> None:
    greeter, record = normal
    assert [c for m in record.moments for c in m.commands] == greeter.robot.log[:-1]
    assert describe(greeter.robot.log[-1]) == "stop"


# ---- recorded people


def assert_at_rest(greeter: Greeter) -> None:
    """Stopped and halted, with nothing left running."""
    stop = greeter.robot.log[-1]
    assert stop.kind is CommandKind.STOP
    assert not any(command.running for command in greeter.robot.log[:-1])
    assert greeter.tree.active_phase is None
    assert {state.status for state in greeter.tree.states()} == {"idle"}


def test_before_a_recorded_person_the_robot_only_turns() -> None:
    greeter = Greeter(Frames(recorded()))
    record = encounter(greeter)
    path = record.robot_path
    assert np.ptp(path[:, :2], axis=0) == pytest.approx([0, 0], abs=1e-9)
    assert path[-1, 2] == pytest.approx(SCRIPTS["normal"].bearing, abs=0.3)
    assert record.phases == IN_ORDER
    # The person is where they were recorded, however the robot has turned.
    last = recorded()[-1].head
    np.testing.assert_allclose(record.person_path[-1], last[:2], atol=0.02)
    assert_at_rest(greeter)


def test_a_robot_of_ones_own_may_drive() -> None:
    greeter = Greeter(Frames(recorded()), robot=PointRobot(leash=None))
    assert np.ptp(encounter(greeter).robot_path[:, 0]) > 0.5


def test_a_caller_who_stops_iterating_leaves_the_robot_stopped() -> None:
    greeter = Greeter(Frames(recorded()))
    moments = greeter.run()
    for moment in moments:
        if any(describe(command) == "wave" for command in moment.commands):
            break
    assert any(command.running for command in greeter.robot.log)
    moments.close()  # type: ignore[attr-defined]
    assert_at_rest(greeter)


def test_a_source_that_fails_leaves_the_robot_stopped() -> None:
    greeter = Greeter(Frames([*recorded()[:90], DataError("torn")]))
    seen: list[Moment] = []
    with pytest.raises(DataError, match="torn"):
        seen.extend(greeter.run())
    assert_at_rest(greeter)


def test_absolute_stamps_change_nothing() -> None:
    here = encounter(Greeter(Frames(recorded())))
    there = encounter(Greeter(Frames(recorded(start=1_700_000_000.0))))
    assert there.moments[0].t == 0.1
    assert there.phases == here.phases
    # A clock that shows 1.7e9 s is rounded to 0.24 µs: a frame may come a tick later.
    assert abs(len(there.moments) - len(here.moments)) <= 1
    assert not math.isnan(there.observations.values[0, 0])
    for label in SALUTATIONS:
        (now,), (then,) = ([a.start for a in r.actions if a.label == label] for r in (there, here))
        assert now == pytest.approx(then, abs=0.21)


def test_nothing_that_comes_later_changes_a_moment() -> None:
    frames = recorded()
    whole = list(Greeter(Frames(frames)).run())
    for cut in (1, 40, 97, 200):
        end = frames[cut].t
        other = [f._replace(head=(9.0, -9.0, 1.0), smile=5.0, dsal=1.0) for f in frames[cut:]]
        changed = list(Greeter(Frames([*frames[:cut], *other])).run())
        before = sum(moment.t < end for moment in whole)
        assert all(map(same, whole[:before], changed[:before]))


# ---- people who are not there


def test_a_source_without_frames_has_no_moments() -> None:
    greeter = Greeter(Frames([]))
    assert list(greeter.run()) == []
    assert_at_rest(greeter)


def test_frames_in_which_nobody_is_seen_move_nobody() -> None:
    greeter = Greeter(Frames(PersonFrame(i / 30) for i in range(90)))
    record = encounter(greeter)
    assert len(record.moments) == 30
    assert {(m.person, m.observation, m.belief) for m in record.moments} == {(None, None, None)}
    assert record.actions == []
    with pytest.raises(ParameterError, match="nothing to read; somebody must be seen"):
        record.require_readings()


def test_a_person_who_comes_late_is_greeted_from_the_first_phase_on() -> None:
    nobody = [PersonFrame(i / 30) for i in range(300)]
    record = encounter(Greeter(Frames([*nobody, *recorded(start=10.0)])))
    assert record.phases == IN_ORDER
    assert record.actions[0].start >= 10


def test_a_person_out_of_sight_is_remembered_for_a_moment_only() -> None:
    frames = recorded()[:31]
    lost = [PersonFrame(1 + i / 30) for i in range(1, 60)]
    moments = list(Greeter(Frames([*frames, *lost])).run())
    for moment in moments:
        assert (moment.person is not None) == (moment.t <= 1 + REMEMBERED + 1e-9)


def lost_for(seconds: float) -> tuple[Encounter, float]:
    """The normal greeting twice, with nobody to be seen between; and when the second begins."""
    first = recorded()
    again = first[-1].t + seconds
    record = encounter(Greeter(Frames([*first, *recorded(start=again)])))
    return record, again


def test_who_comes_back_after_a_while_is_greeted_anew() -> None:
    record, again = lost_for(FORGOTTEN + 1)
    forgotten = [m for m in record.moments if again - 0.9 < m.t < again]
    assert {(m.person, m.belief, m.commands) for m in forgotten} == {(None, None, ())}
    assert record.phases == IN_ORDER * 2
    labels = [action.label for action in record.actions]
    assert [labels.count(label) for label in ("wave", "handshake")] == [2, 2]


def test_a_short_loss_ends_no_greeting() -> None:
    frames = recorded()
    arrived = next(i for i, f in enumerate(frames) if f.csal == 1)
    late = [f._replace(t=f.t + FORGOTTEN - 1) for f in frames[arrived + 30 :]]
    record = encounter(Greeter(Frames([*frames[: arrived + 30], *late])))
    assert record.phases == IN_ORDER
    assert [action.label for action in record.actions].count("handshake") == 1


# ---- robots that do not do as they are told


class Deaf(PointRobot):
    """A robot that takes commands and never answers."""

    def _advance(self, dt: float) -> None:
        del dt


def test_a_robot_that_stops_answering_does_not_stop_the_flow() -> None:
    robot = Deaf(patience=1.0)
    greeter = Greeter(Frames(recorded()), robot=robot)
    record = encounter(greeter)
    assert record.phases == IN_ORDER
    assert record.duration == pytest.approx(recorded()[-1].t, abs=0.11)
    failed = [c for c in robot.log if c.status is CommandStatus.FAILED]
    assert failed
    assert {c.reason for c in failed} == {"the robot has not answered for 1 s"}
    assert_at_rest(greeter)


def test_a_track_file_is_greeted_like_its_track(tmp_path: Path) -> None:
    from kendon.tracks import write_track

    write_track(Track.from_frames(recorded(), "person"), tmp_path / "person.csv")
    assert encounter(Greeter(open_source(tmp_path / "person.csv"))).phases == IN_ORDER


def test_a_track_in_memory_is_greeted_as_its_file_would_be() -> None:
    track = Track.from_frames(recorded())
    in_memory = [m.belief.phase for m in Greeter(RecordedSource(track)).run() if m.belief]
    from_frames = [m.belief.phase for m in Greeter(Frames(recorded())).run() if m.belief]
    assert in_memory == from_frames
    with pytest.raises(DataError, match="made in Python"):
        RecordedSource.open("person.csv", SourceOptions())


def test_somebody_else_is_greeted_anew() -> None:
    first = [frame._replace(who=1) for frame in recorded()]
    end = first[-1].t
    second = [frame._replace(t=end + 0.5 + frame.t, who=2) for frame in recorded()]
    both = encounter(Greeter(Frames(first + second)))
    assert both.phases[: len(IN_ORDER)] == IN_ORDER
    anew = [m.belief.phase for m in both.moments if m.t > end + 0.5 and m.belief]
    order = [phase for i, phase in enumerate(anew) if i == 0 or phase is not anew[i - 1]]
    assert order[0] is Phase.IA  # a person who is greeted stays greeted; a new one begins
    same = encounter(Greeter(Frames(first + [frame._replace(who=1) for frame in second])))
    kept = [m.belief.phase for m in same.moments if m.t > end + 0.5 and m.belief]
    assert kept[0] is Phase.CS
