"""Robot files: what is wrong with one is told in a sentence; any MJCF or URDF can be a robot."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from robots.robot_contract import run_until_ended

from kendon.errors import DataError, KendonError, ParameterError, UnknownNameError
from kendon.geometry import Pose2D
from kendon.robots import PointRobot, RobotOptions, make_robot, robot_kinds
from kendon.robots.base import CommandStatus
from kendon.robots.mujoco import MujocoRobot, read_description

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "robot"

#: The same robot's head in MJCF, with a free joint and motors of its own, which are replaced.
MJCF = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="base_link">
      <freejoint/>
      <geom size="0.2"/>
      <body name="neck" pos="0 0 1">
        <joint name="head_pan" axis="0 0 -1" range="-90 90"/>
        <geom size="0.05"/>
        <body name="head">
          <joint name="head_tilt" axis="0 1 0" range="-45 45"/>
          <geom size="0.1"/>
          <site name="face" pos="0.1 0.02 0.05"/>
          <body name="lift" pos="0 -0.2 0">
            <joint name="lift" type="slide" axis="0 0 1" range="0 0.3"/>
            <geom size="0.03"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="lift"/></actuator>
</mujoco>
"""
MAPPING = """
title = "a lift"
model = "lift.xml"
[base]
body = "base_link"
[head]
pan = "head_pan"
tilt = "head_tilt"
face = "face"
[speeds]
"head_*" = 2
lift = 0.2
[[gestures.home]]
t = 1
rest = true
[[gestures.wave]]
t = 0.5
lift = 0.3
[[gestures.wave]]
t = 3
rest = true
[[gestures.handshake]]
t = 2
lift = 0.1
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for file in EXAMPLE.iterdir():
        shutil.copy(file, tmp_path)
    (tmp_path / "lift.xml").write_text(MJCF)
    (tmp_path / "lift.toml").write_text(MAPPING)
    return tmp_path


def test_an_mjcf_with_motors_of_its_own_can_be_a_robot(folder: Path) -> None:
    robot = MujocoRobot(description=read_description(folder / "lift.toml"))
    assert robot.gestures == ("home", "wave", "handshake")
    assert robot.expressions == ("neutral",)
    wave = robot.gesture("wave")  # too fast for a lift of 0.2 m/s: it takes longer as a whole
    for _ in range(300):
        robot.update(robot.time + 0.02)
        assert abs(robot.body.velocities[-1]) <= 0.2 * 1.01
    assert robot.body.angles[-1] > 0.1
    run_until_ended(robot, wave)
    assert wave.ended > 9.0
    drive, look = robot.go_to(Pose2D(0.5, 0.0, 0.0)), robot.look_at((2.0, 1.0, 1.5))
    run_until_ended(robot, drive)
    assert drive.status is look.status is CommandStatus.SUCCEEDED
    assert robot.pan > 0


def test_a_urdfs_own_speeds_count_unless_others_are_given(folder: Path) -> None:
    robot = MujocoRobot(description=read_description(folder / "pan_tilt.toml"))
    body = robot.body
    assert body.speeds[body.index("test", "shoulder")] == 3.0
    text = (folder / "pan_tilt.toml").read_text() + "\n[speeds]\n'shoulder' = 1.5\n"
    (folder / "slow.toml").write_text(text)
    slow = MujocoRobot(description=read_description(folder / "slow.toml")).body
    assert slow.speeds[slow.index("test", "shoulder")] == 1.5
    assert slow.speeds[slow.index("test", "elbow")] == 3.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('pan = "head_pan"', 'pan = "neck"', r"head\.pan: there is no joint 'neck'; valid"),
        ('tilt = "head_tilt"', 'tilt = "head_titl"', r"did you mean 'head_tilt'"),
        ('face = "face"', 'face = "nose"', r"head\.face: there is no site or body 'nose'; valid"),
        ('body = "base_link"', 'body = "head"', r"root body 'head'; valid: base_link"),
        ('hand = "hand"', 'hand = "fist"', r"hand: there is no site or body 'fist'"),
        ('left = "left_wheel_joint"', 'left = "wheel"', r"base\.wheels: there is no joint 'wheel'"),
        ("radius = 0.1", "radius = 0", r"base\.wheels\.radius is a number above 0, not 0"),
        ("speed = 0.4 ", "speed = -1 ", r"a base's speed is a positive, finite number, not -1"),
        ("speed = 0.4 ", "speeed = 0.4 ", r"base: there is no key 'speeed'"),
        ("shoulder = 120", "shoulder = 200", r"shoulder goes from .* to 160\.4, not to 200"),
        ("shoulder = 120", "shuolder = 120", r"gestures\.wave: there is no joint 'shuolder'"),
        ("shoulder = 120", "shoulder = nan", r"gestures\.wave\[0\]\.shoulder is a finite number"),
        ("shoulder = 120", 'shoulder = "up"', r"is a finite number, not 'up'"),
        ("t = 1.2", "t = 0", r"gestures\.wave\[0\] needs a time t \[s\] after 0, not 0"),
        ("t = 1.6", "t = 1.2", r"gestures\.wave\[1\] needs a time t \[s\] after 1\.2"),
        ("hold = true", "hold = 1", r"hold is true or false, not 1"),
        ("[[gestures.handshake]]", "[[gestures.hug]]", r"gestures lacks 'handshake'"),
        ("elbow = 10", "elbow = -30", r"rest: elbow goes from 0 to"),
        ("mouth_left_joint = 22", "mouth = 22", r"expressions\.smile: there is no joint 'mouth'"),
        ('title = "a head on a pole, with one arm"', "", r"the file lacks 'title'"),
        ('model = "pan_tilt.urdf"', 'model = "gone.urdf"', r"gone\.urdf .*: there is no such"),
        ('model = "pan_tilt.urdf"', 'model = "broken.urdf"', r"broken\.urdf cannot be read"),
        ('model = "pan_tilt.urdf"', "model = 3", r"model is a text, not 3"),
        ('pan = "head_pan"', 'pan = "head_tilt"', r"needs a pan joint about the vertical"),
        ('tilt = "head_tilt"', 'tilt = "mouth_left_joint"', r"a tilt joint across it"),
        ("[head]", "[head]\ntilt_range = [1]", r"tilt_range is \[lowest, highest\]"),
        ("title", "title = [", r"not a readable robot file"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_robot_file_is_told(folder: Path, old: str, new: str, message: str) -> None:
    text = (folder / "pan_tilt.toml").read_text()
    assert old in text
    (folder / "broken.urdf").write_text("<robot")
    (folder / "wrong.toml").write_text(text.replace(old, new))
    with pytest.raises(DataError, match=message) as caught:
        MujocoRobot(description=read_description(folder / "wrong.toml"))
    assert str(caught.value).startswith(str(folder / "wrong.toml"))
    assert "\n" not in str(caught.value)


def test_a_joint_without_a_speed_is_told(folder: Path) -> None:
    (folder / "lift.toml").write_text(MAPPING.replace("lift = 0.2", ""))
    with pytest.raises(DataError, match="speeds lacks 'lift'"):
        MujocoRobot(description=read_description(folder / "lift.toml"))
    (folder / "lift.toml").write_text(MAPPING.replace('"head_*"', '"neck_*"'))
    with pytest.raises(DataError, match=r"there is no joint 'neck_\*'; valid: head_pan"):
        MujocoRobot(description=read_description(folder / "lift.toml"))


def test_a_ball_joint_is_no_servo(folder: Path) -> None:
    (folder / "lift.xml").write_text(
        MJCF.replace('<joint name="lift" type="slide" axis="0 0 1" range="0 0.3"/>',
                     '<joint name="lift" type="ball"/>').replace('<motor joint="lift"/>', "")
    )  # fmt: skip
    with pytest.raises(DataError, match="'lift' neither turns about one axis nor slides"):
        MujocoRobot(description=read_description(folder / "lift.toml"))


# ---- the register


def test_robots_are_made_by_name() -> None:
    assert list(robot_kinds()) == ["point", "mujoco"]
    point = make_robot("point", RobotOptions(face=(0.1, 0.0, 1.0), leash=0.0))
    assert isinstance(point, PointRobot)
    assert point.face == (0.1, 0.0, 1.0)
    assert isinstance(make_robot("mujoco"), MujocoRobot)
    simple = make_robot(str(EXAMPLE / "pan_tilt.toml"), RobotOptions(leash=0.0))
    assert isinstance(simple, MujocoRobot)
    assert simple.go_to(Pose2D(1.0, 0.0, 0.0)).sent["goal"] == Pose2D(0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("spec", "options", "error", "message"),
    [
        ("mujocco", None, UnknownNameError, "robot 'mujocco'; valid: point, mujoco, or a path"),
        ("gone.toml", None, DataError, r"gone\.toml: there is no such robot file"),
        (str(EXAMPLE / "pan_tilt.urdf"), None, DataError, r"by a \.toml file"),
        ("mujoco", RobotOptions((0, 0, 1)), ParameterError, "only be given for the robot 'point'"),
    ],
)  # fmt: skip
def test_a_robot_that_does_not_exist_is_told(
    spec: str, options: RobotOptions | None, error: type[KendonError], message: str
) -> None:
    with pytest.raises(error, match=message):
        make_robot(spec, options)
