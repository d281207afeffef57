"""Pictures and films: the person's drawn body, what is shown when, and files that open again."""

from __future__ import annotations

import ctypes.util
import math
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from kendon import Encounter, Greeter, open_source
from kendon.errors import DataError, ParameterError, RendererError
from kendon.geometry import Pose2D, yaw_quaternion
from kendon.person import JOINTS
from kendon.phases import Phase
from kendon.robots.mujoco import MujocoRobot
from kendon.viewer import pictures
from kendon.viewer.mannequin import Stance, shapes
from kendon.viewer.scenes import Scenes
from kendon.viewer.stage import Stage, gl_context, require_renderer

Run = tuple[Encounter, MujocoRobot]


@pytest.fixture(scope="module")
def run() -> Run:
    robot = MujocoRobot()
    robot.history = []
    encounter = Encounter("a greeting")
    for moment in Greeter(open_source("simulated"), robot=robot).run():
        encounter.add(moment)
    return encounter, robot


@pytest.fixture
def renderer() -> None:
    try:
        require_renderer()
    except RendererError as error:
        pytest.skip(str(error))


def standing(**changes: object) -> Stance:
    values = {"head": (2.0, 1.0, 1.6), "head_rotation": yaw_quaternion(math.pi),
              "heading": math.pi, "joints": {}} | changes  # fmt: skip
    return Stance(**values)  # type: ignore[arg-type]


class TestMannequin:
    def test_it_stands_on_the_floor_below_its_face(self) -> None:
        drawn = shapes(standing())
        lowest = min(min(s.start[2], s.end[2]) - s.radius for s in drawn)
        highest = max(max(s.start[2], s.end[2]) + s.radius for s in drawn)
        assert lowest == pytest.approx(0.0, abs=0.04)
        assert 1.65 < highest < 1.85
        middle = np.mean([(s.start + s.end) / 2 for s in drawn], axis=0)
        assert middle[:2] == pytest.approx([2.1, 1.0], abs=0.08)

    def test_it_is_drawn_where_joints_are_known(self) -> None:
        wrist, elbow = (1.6, 1.3, 1.5), (1.8, 1.35, 1.2)
        drawn = shapes(standing(joints={"r_wrist": wrist, "r_elbow": elbow}))
        assert any(s.start == pytest.approx(elbow) and s.end == pytest.approx(wrist) for s in drawn)
        known = {name: (1.0, 0.1 * i, 1.0 + 0.05 * i) for i, name in enumerate(JOINTS)}
        ends = np.array([p for s in shapes(standing(joints=known)) for p in (s.start, s.end)])
        for point in known.values():
            assert np.abs(ends - point).sum(axis=1).min() < 1e-9

    def test_a_wave_raises_the_right_hand(self) -> None:
        def highest_hand(stance: Stance) -> float:
            # The right is y > 1 for somebody who faces -x; hands are the last shapes of an arm.
            return max(
                float(s.end[2]) for s in shapes(stance) if s.end[1] > 1.25 and s.radius < 0.045
            )

        assert highest_hand(standing(wave=1.0)) > 1.6 > highest_hand(standing()) + 0.4

    def test_a_hand_held_out_comes_to_the_target(self) -> None:
        target = (1.45, 1.05, 1.05)
        drawn = shapes(standing(reach=1.0, target=target))
        assert min(np.linalg.norm(s.end - target) for s in drawn) < 0.08
        far = shapes(standing(reach=1.0, target=(0.0, 1.0, 0.5)))
        arm = [s for s in far if s.radius == pytest.approx(0.052 * 1.6 / 0.936 / 1.72)]
        assert all(np.linalg.norm(s.end - s.start) < 0.35 for s in arm)  # it is not stretched

    @pytest.mark.parametrize("walked", np.linspace(0.0, 1.4, 8))
    def test_walking_legs_keep_their_lengths_and_the_feet_off_the_ground(
        self, walked: float
    ) -> None:
        drawn = shapes(standing(walked=walked, stride=1.0))
        assert min(min(s.start[2], s.end[2]) for s in drawn) > 0.0
        thighs = [s for s in drawn if s.radius == pytest.approx(0.078 * 1.6 / 0.936 / 1.72)]
        for thigh in thighs:
            assert np.linalg.norm(thigh.end - thigh.start) == pytest.approx(0.42, abs=0.06)


class TestScenes:
    def test_there_is_an_instant_for_every_image(self, run: Run) -> None:
        encounter, robot = run
        film = Scenes(encounter, robot).film(20.0)
        assert len(film) == int(encounter.duration * 20) + 1
        assert [i.t for i in film] == pytest.approx(np.arange(len(film)) / 20)
        # Between ticks the person goes on, and the camera does not jump.
        heads = np.array([i.stance.head for i in film if i.stance is not None])
        assert np.abs(np.diff(heads, axis=0)).max() < 1.3 / 20 * 1.5
        eyes = np.array([i.view.look_at for i in film])
        assert np.abs(np.diff(eyes, axis=0)).max() < 0.1
        assert film[-1].saying == ""
        assert any("Pleased" in i.saying for i in film)
        assert any("wave" in i.doing for i in film)

    def test_every_phase_has_its_highlight_in_their_order(self, run: Run) -> None:
        instants = Scenes(*run).highlights()
        assert {i.phase for i in instants} == set(Phase)
        assert [i.t for i in instants] == sorted(i.t for i in instants)
        wave = next(i for i in instants if i.phase is Phase.DS)
        assert "wave" in wave.doing
        shake = next(i for i in instants if i.phase is Phase.CS)
        assert "handshake" in shake.doing
        assert shake.stance is not None
        assert shake.stance.reach == pytest.approx(1.0)
        assert shake.stance.target is not None

    def test_robot_and_person_are_in_the_image(self, run: Run) -> None:
        for instant in Scenes(*run).film(5.0):
            view = instant.view
            ahead = np.array([math.cos(view.azimuth), math.sin(view.azimuth)])
            right = np.array([ahead[1], -ahead[0]])
            places = [instant.robot[:2]]
            if instant.stance is not None:
                places.append(instant.stance.head[:2])
            for place in places:
                off = np.array(place) - view.look_at[:2]
                depth = view.distance * math.cos(view.elevation) + off @ ahead
                half = depth * math.tan(math.radians(45) / 2) * 16 / 9
                assert abs(off @ right) < half - 0.25

    def test_without_a_history_there_is_nothing_to_draw(self, run: Run) -> None:
        with pytest.raises(ParameterError, match="history is empty"):
            Scenes(run[0], MujocoRobot())


@pytest.mark.usefixtures("renderer")
class TestDrawing:
    def test_a_stage_shows_the_robot_in_its_colours(self) -> None:
        robot = MujocoRobot()
        stage = Stage(robot.description, 160, 120)
        stage.pose(robot.body.data.qpos)
        image = stage.draw((0.0, 0.0, 0.6), 2.2, math.pi, -0.1)
        stage.close()
        assert image.shape == (120, 160, 3)
        r, g, b = (image[:, :, i].astype(int) for i in range(3))
        assert ((g > r + 40) & (b > r + 40)).sum() > 50  # the shoulders' and the cap's teal

    def test_a_smile_changes_the_face(self) -> None:
        robot = MujocoRobot()
        stage = Stage(robot.description, 200, 200)

        def face() -> object:
            stage.pose(robot.body.data.qpos)
            x, y, z = robot.face
            return stage.draw((x, y, z - 0.05), 0.45, math.pi, 0.0)

        before = face()
        robot.express("smile")
        robot.update(2.0)
        after = face()
        stage.close()
        lips = [
            np.argwhere((i[:, :, 0] > i[:, :, 1] + 40) & (i[:, :, 1] < 110))  # type: ignore[index]
            for i in (before, after)
        ]
        heights = [np.ptp(rows[:, 0]) for rows in lips]
        assert heights[1] > heights[0] + 2

    def test_the_person_is_drawn_where_they_are(self) -> None:
        robot = MujocoRobot()
        stage = Stage(robot.description, 160, 120)
        stage.pose(robot.body.data.qpos)
        camera = ((1.0, 0.0, 0.8), 4.0, math.pi / 2, -0.1)
        person = shapes(standing(head=(1.8, 0.0, 1.6)))
        without, there = stage.draw(*camera), stage.draw(*camera, person)
        zones = stage.draw(*camera, person, zones=Pose2D(0.0, 0.0, 0.0))
        stage.close()
        changed = np.argwhere(np.abs(there.astype(int) - without).sum(axis=2) > 60)
        assert changed[:, 1].mean() > 90  # to the right of the middle
        assert (zones != there).mean() > 0.1

    def test_a_sheet_has_an_image_of_each_phase(self, run: Run, tmp_path: Path,
        monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
        monkeypatch.setattr(pictures, "_SHEET_SIZE", (240, 135))
        path = tmp_path / "new" / "sheet.png"
        pictures.write_picture(*run, path)
        sheet = matplotlib.image.imread(path)
        assert sheet.shape[:2] == (3 * 135 + 2 * 8, 2 * 240 + 8)
        assert sheet[:, :, :3].std() > 0.05

    @pytest.mark.parametrize("kind", [".mp4", ".webm"])
    def test_a_film_can_be_read_again(
        self, run: Run, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        cv2 = pytest.importorskip("cv2")
        monkeypatch.setattr(pictures, "FILM_RATE", 0.3)
        monkeypatch.setattr(pictures, "FILM_SIZE", (240, 136))
        path = tmp_path / f"film{kind}"
        told: list[tuple[int, int]] = []
        pictures.write_film(*run, path, lambda done, count: told.append((done, count)))
        film = cv2.VideoCapture(str(path))
        images = 0
        while film.read()[0]:
            images += 1
        film.release()
        assert images == len(told) == told[-1][0] == told[-1][1] == int(run[0].duration * 0.3) + 1
        assert list(tmp_path.iterdir()) == [path]

    def test_a_film_that_fails_leaves_nothing(
        self, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        pytest.importorskip("cv2")
        monkeypatch.setattr(pictures, "FILM_SIZE", (240, 136))

        def stop(done: int, count: int) -> None:
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            pictures.write_film(*run, tmp_path / "film.mp4", stop)
        assert list(tmp_path.iterdir()) == []
        (tmp_path / "file").touch()
        with pytest.raises(DataError, match="cannot be written"):
            pictures.write_film(*run, tmp_path / "file" / "film.mp4")


def test_what_to_install_is_told_where_nothing_can_draw(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: None)
    with pytest.raises(RendererError, match=r"EGL or OSMesa.*apt-get install libegl1.*libosmesa6"):
        gl_context(16, 16)


@pytest.mark.parametrize("error", [ctypes.ArgumentError, ImportError, AttributeError, RuntimeError])
def test_a_half_installed_renderer_is_told_of(
    error: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    def import_module(name: str) -> None:
        assert name == "mujoco.egl"
        raise error("'NoneType' object has no attribute 'glGetError'")

    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("MUJOCO_GL", "egl")
    monkeypatch.setattr("kendon.viewer.stage.importlib.import_module", import_module)
    with pytest.raises(RendererError, match=r"EGL .* does not draw \(.*glGetError.*libopengl0"):
        gl_context(16, 16)
