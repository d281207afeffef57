"""What the page draws and writes: bodies, charts, the tree, the log; without a browser."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from viewer.browser import encounters

from kendon.errors import DataError
from kendon.geometry import Pose2D, yaw_quaternion
from kendon.observations import Observation
from kendon.person import JOINTS, PersonFrame
from kendon.phases import Phase
from kendon.robots import PointRobot
from kendon.viewer.browser.cameras import floor_point
from kendon.viewer.browser.charts import chart_values, draw_charts
from kendon.viewer.browser.forms import COLUMNS, Pieces
from kendon.viewer.browser.panels import command_log, log_rows, phase_card, tree_view
from kendon.viewer.browser.person_form import Follower, draw_person, stance
from kendon.viewer.browser.robot_form import robot_form
from kendon.viewer.browser.session import Session


@pytest.fixture(scope="module")
def session() -> Session:
    session = encounters.simulated()
    encounters.pass_time(session, 9.0)
    return session


_POINT = st.tuples(*[st.floats(-5, 5)] * 3)


@given(start=_POINT, end=_POINT)
def test_a_rod_lies_between_its_capsule_s_ends(
    start: tuple[float, ...], end: tuple[float, ...]
) -> None:
    a, b = np.array(start), np.array(end)
    pieces = Pieces()
    pieces.capsule(a, b, 0.1, (0, 0, 0))
    balls, rods = pieces.arrays()
    assert balls.shape[1] == COLUMNS
    assert balls[0, :3] == pytest.approx(a, abs=1e-4)
    if len(rods):
        place, (w, x, y, z), length = rods[0, :3], rods[0, 3:7], rods[0, 9]
        half = Rotation.from_quat([x, y, z, w]).apply([0, 0, length / 2])
        assert place - half == pytest.approx(a, abs=1e-3)
        assert place + half == pytest.approx(b, abs=1e-3)


@given(yaw=st.floats(-3, 3), x=st.floats(-5, 5), y=st.floats(-5, 5), facing=st.floats(-3, 3))
def test_a_person_is_followed_in_the_world_wherever_the_robot_stands(
    yaw: float, x: float, y: float, facing: float
) -> None:
    left = (-math.sin(facing), math.cos(facing))
    joints = {
        f"{side}_{name}": (2 + sign * 0.2 * left[0], 1 + sign * 0.2 * left[1], 1.0)
        for side, sign in (("l", 1), ("r", -1))
        for name in ("shoulder", "hip")
    }
    frame = PersonFrame(0.0, (2.0, 1.0, 1.6), yaw_quaternion(facing), joints=joints, smile=2.0)
    row = Follower().take(frame.seen_from(Pose2D(x, y, yaw)))
    assert row is not None
    seen = stance(row)
    assert seen.head == pytest.approx((2.0, 1.0, 1.6), abs=1e-4)
    assert math.cos(seen.heading - facing) == pytest.approx(1.0, abs=1e-4)
    assert set(seen.joints) == set(joints) <= set(JOINTS)
    assert seen.smile == 2.0


def test_who_walks_strides_and_who_is_only_a_face_has_a_body_too() -> None:
    follower, row = Follower(), None
    for i in range(40):
        row = follower.take(PersonFrame(i / 20, (4 - 0.06 * i, 0.0, 1.6)))
    assert row is not None
    seen = stance(row)
    assert seen.stride == pytest.approx(1.0, abs=0.05)
    assert seen.walked == pytest.approx(1.2 * 1.95, abs=0.4)
    assert abs(seen.heading) == pytest.approx(math.pi, abs=0.01)  # nothing known: to the robot
    balls, _ = draw_person(row).arrays()
    assert np.isfinite(balls).all()
    assert balls[:, 2].min() > -0.02
    assert follower.take(PersonFrame(3.0)) is None


def test_who_bows_does_not_shrink() -> None:
    follower = Follower()
    follower.take(PersonFrame(0.0, (2.0, 0.0, 1.6)))
    row = follower.take(PersonFrame(0.1, (1.8, 0.0, 1.2)))
    assert row is not None
    assert stance(row).size == pytest.approx(1.6 / 0.903, rel=1e-3)


@pytest.mark.parametrize("name", ["point", "mujoco"])
def test_a_robot_is_drawn_where_it_stands_with_its_face_where_it_looks(name: str) -> None:
    session = encounters.simulated(robot=name)
    encounters.pass_time(session, 5.0)
    stage = session.stage
    shown = stage.shown(session.place)
    pieces, face, (w, x, y, z) = stage.form.draw(shown.robot)
    balls, rods = pieces.arrays()
    assert np.isfinite(balls).all()
    assert np.isfinite(rods).all()
    pose = stage.robot.pose
    assert shown.robot[:3] == pytest.approx(tuple(pose), abs=1e-5)
    assert np.hypot(balls[:, 0] - pose.x, balls[:, 1] - pose.y).max() < 1.0
    assert balls[:, 2].min() > -0.02
    assert balls[:, 2].max() == pytest.approx(stage.robot.face[2], abs=0.4)
    looks = Rotation.from_quat([x, y, z, w]).apply([1, 0, 0])
    assert math.cos(math.atan2(looks[1], looks[0]) - pose.yaw) > 0.3
    assert math.dist(face[:2], pose[:2]) < 0.4


def test_a_wave_lifts_the_plain_body_s_hand_over_its_head() -> None:
    robot = PointRobot()
    form = robot_form(robot)

    def highest() -> float:
        balls, _ = form.draw(form.state(robot))[0].arrays()
        return float(balls[balls[:, 1] < -0.25][:, 2].max())  # of the right side

    assert highest() < 1.0
    robot.gesture("wave")
    for tick in range(1, 15):
        robot.update(tick / 10)
        top = highest()
    assert top > 1.05


def test_the_card_tells_the_phase_in_words(session: Session) -> None:
    last = session.stage.snapshots[-1]
    for phase in Phase:
        card = phase_card(replace(last, phase=phase, saying="<b>Hi</b>"))
        ElementTree.fromstring(f"<div>{card}</div>")
        assert phase.title in card
        assert f'data-phase="{phase.name}"' in card
        assert "&lt;b&gt;Hi" in card
    assert "Nobody" in phase_card(replace(last, phase=None))


def test_the_tree_shows_the_subtree_that_is_at_work(session: Session) -> None:
    stage = session.stage
    waving = next(s for s in stage.snapshots if s.phase is Phase.DS and "waves" in s.doing)
    view = tree_view(stage.nodes, waving.nodes)
    ElementTree.fromstring(f"<div>{view}</div>")
    assert "Distance Salutation" in view
    assert "Look at the face" in view
    assert "Avert the gaze" not in view  # the approach's own
    assert "Force Success" not in view


def test_the_log_tells_each_command_once_newest_first(session: Session) -> None:
    actions = list(session.stage.actions)
    rows = log_rows(actions)
    assert [t for t, _ in rows] == sorted(t for t, _ in rows)
    assert sum("<b>base</b> drive" in row for _, row in rows) < sum(
        a.label == "drive" for a in actions
    )
    log = command_log(actions, 1e9)
    ElementTree.fromstring(log)
    assert log.index("handshake") < log.index("wave")
    assert "handshake" not in command_log(actions, 3.0)
    assert "nothing yet" in command_log([], 3.0)


def test_the_charts_are_pictures_of_what_was_observed(session: Session) -> None:
    snapshots = list(session.stage.snapshots)
    svg = ElementTree.fromstring(draw_charts(snapshots, 0.0, 20.0))
    assert {e.get("fill") for e in svg.iter("polygon")} <= {p.color for p in Phase}
    assert len(list(svg.iter("polyline"))) == 4  # distance, speed, gaze, smile
    assert any(e.get("fill") == Phase.DS.color for e in svg.iter("rect"))
    words = " ".join(e.text or "" for e in svg.iter("text"))
    for word in ("distance", "speed", "gaze", "smile", "20 s", "CS 1.00"):
        assert word in words


def test_the_numbers_beside_the_charts_are_those_of_an_instant(session: Session) -> None:
    snapshots = list(session.stage.snapshots)
    for snapshot in (snapshots[8], snapshots[-1]):
        assert snapshot.observation is not None
        words = [text for _, _, text in chart_values(snapshot)]
        assert f"{snapshot.observation.distance:.1f} m" in words
        assert any(w.startswith(snapshot.phase.name) for w in words if snapshot.phase)
    written = draw_charts(snapshots, 0.0, 20.0)
    assert all(f">{text}</text>" in written for _, _, text in chart_values(snapshots[-1]))
    bare = draw_charts(snapshots, 0.0, 20.0, values=False)
    assert "CS 1.00" not in bare
    assert '<g class="values"></g>' in bare


_FIRST = encounters.simulated("simulated:short").stage
_VALUE = st.one_of(st.just(math.nan), st.floats(0, 5))


@given(rows=st.lists(st.tuples(*[_VALUE] * 7), max_size=8))
def test_charts_can_be_drawn_of_whatever_is_unknown(rows: list[tuple[float, ...]]) -> None:
    first = _FIRST.snapshots[0]
    snapshots = [
        replace(first, t=0.2 * i, is_new=True, observation=Observation(0.2 * i, *row))
        for i, row in enumerate(rows)
    ]
    drawn = draw_charts(snapshots, 0.0, 2.0)
    ElementTree.fromstring(drawn)
    assert "nan" not in drawn


@given(
    x=st.floats(-9, 9), y=st.floats(-9, 9), share=st.floats(0.05, 0.95),
    eye=st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(0.5, 9)),
)  # fmt: skip
def test_a_pointer_over_the_floor_means_the_place_under_it(
    x: float, y: float, share: float, eye: tuple[float, float, float]
) -> None:
    through = tuple(e + share * (f - e) for e, f in zip(eye, (x, y, 0.0), strict=True))
    assert floor_point(eye, (through[0], through[1], through[2])) == pytest.approx((x, y), abs=1e-6)


def test_a_pointer_in_the_sky_means_no_place() -> None:
    assert floor_point((0.0, 0.0, 1.0), (1.0, 0.0, 1.5)) is None


def test_a_replay_that_could_not_be_written_is_refused_at_once(tmp_path: Path) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    from kendon.viewer.browser.replay import check_replay

    (tmp_path / "file").write_text("x")
    (tmp_path / "folder.html").mkdir()
    for name, why in (
        ("replay.txt", "is a .html file"),
        ("folder.html", "this is a folder"),
        ("file/replay.html", "cannot be written"),
    ):
        with pytest.raises(DataError, match=why):
            check_replay(tmp_path / name)
    check_replay(tmp_path / "new" / "replay.html")
    assert not (tmp_path / "new" / "replay.html").exists()
