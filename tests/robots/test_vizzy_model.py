"""The model of Vizzy, link by link, against the maker's numbers."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kendon.robots.mujoco import MujocoRobot

#: Name of the joint: parent, child, xyz [m], rpy [rad], lowest and highest [rad], speed [rad/s];
#: 1.571 and 3.142 stand for right and straight angles.
LINKS = """
r_wheel_joint base_link r_wheel_link 0.1899 0.245 0.1581 1.571 1.571 0
l_wheel_joint base_link l_wheel_link 0.1899 -0.245 0.1581 1.571 1.571 0
waist_joint base_link waist_link 0.1935 0 0.5407 1.571 0 0 -0.349 0.349 0.593
neck_pan_joint waist_link neck_pan_link 0 0 0 1.571 0 0 -2.03 2.03 5
neck_tilt_joint neck_pan_link neck_tilt_link 0 0 -0.37 1.571 0 0 -2.01 2.46 5
eyes_tilt_joint neck_tilt_link eyes_tilt_link -0.1238 -0.04755 0 3.142 0 -2.772 -0.663 0.663 5
eyes_center_joint eyes_tilt_link eyes_center_link 0 0 0 1.571 0 0.3696
l_eye_joint eyes_center_link l_eye_link 0 0.102 0 0 3.142 0 -1 1 5
r_eye_joint eyes_center_link r_eye_link 0 -0.102 0 0 3.142 0 -1 1 5
l_shoulder_scapula_joint waist_link l_shoulder_scapula_link 0 0 0.0805 1.571 0 -0.0175 -0.314 0.314 3
l_shoulder_flection_joint l_shoulder_scapula_link l_shoulder_flection_link 0 0 -0.212 1.571 0 0 -1.31 2.36 3
l_shoulder_abduction_joint l_shoulder_flection_link l_shoulder_abduction_link 0 0 -0.1026 1.571 0 -1.571 0 1.31 3
l_shoulder_rotation_joint l_shoulder_abduction_link l_shoulder_rotation_link 0 0 0 1.571 0 1.92 -1.48 1.48 3
l_elbow_flection_joint l_shoulder_rotation_link l_elbow_flection_link 0 0 -0.163 1.571 0 1.571 0 1.92 3
l_forearm_pronation_joint l_elbow_flection_link l_forearm_pronation_link 0 0 0 1.571 0 0.0873 -1.48 1.48 3
l_wrist_abduction_joint l_forearm_pronation_link l_wrist_abduction_link 0 0 0.1893 1.571 0 0 -0.611 0.611 3
l_wrist_flection_joint l_wrist_abduction_link l_wrist_flection_link 0 0 0 1.571 0 -1.571 -0.611 0.611 3
r_shoulder_scapula_joint waist_link r_shoulder_scapula_link 0 0 -0.0805 1.571 0 3.124 -0.314 0.314 3
r_shoulder_flection_joint r_shoulder_scapula_link r_shoulder_flection_link 0 0 0.212 1.571 0 0 -1.31 2.36 3
r_shoulder_abduction_joint r_shoulder_flection_link r_shoulder_abduction_link 0 0 0.1026 1.571 0 -1.571 0 1.31 3
r_shoulder_rotation_joint r_shoulder_abduction_link r_shoulder_rotation_link 0 0 0 1.571 0 1.92 -1.48 1.48 3
r_elbow_flection_joint r_shoulder_rotation_link r_elbow_flection_link 0 0 0.163 1.571 0 1.571 0 1.92 3
r_forearm_pronation_joint r_elbow_flection_link r_forearm_pronation_link 0 0 0 1.571 0 0.0873 -1.48 1.48 3
r_wrist_abduction_joint r_forearm_pronation_link r_wrist_abduction_link 0 0 -0.1893 1.571 0 0 -0.611 0.611 3
r_wrist_flection_joint r_wrist_abduction_link r_wrist_flection_link 0 0 0 1.571 0 -1.571 -0.611 0.611 3
"""  # noqa: E501


class TestVizzysModel:
    links = tuple(line.split() for line in LINKS.strip().splitlines())
    right_angles = {"1.571": math.pi / 2, "-1.571": -math.pi / 2, "3.142": math.pi}  # noqa: RUF012

    @settings(max_examples=20, deadline=None)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_every_link_is_where_the_composed_transforms_put_it(self, seed: int) -> None:
        body = MujocoRobot().body
        rng = np.random.default_rng(seed)
        angles = {
            joint: rng.uniform(float(rest[6]), float(rest[7])) if len(rest) > 6 else 0.0
            for joint, _, _, *rest in self.links
        }
        for joint, value in angles.items():
            if joint != "eyes_center_joint":  # a fixed one
                body.data.joint(joint).qpos = value
        mujoco.mj_kinematics(body.model, body.data)
        # base_footprint to base_link: the maker's, without the 4 cm below the floor.
        frames = {"base_link": (np.array([0.1935, 0.0, 0.0]), Rotation.from_euler("z", math.pi))}
        for joint, parent, child, *rest in self.links:
            place, turn = frames[parent]
            xyz = np.array([float(v) for v in rest[:3]])
            rpy = [self.right_angles.get(v, float(v)) for v in rest[3:6]]
            frames[child] = (
                place + turn.apply(xyz),
                turn
                * Rotation.from_euler("xyz", rpy)
                * Rotation.from_rotvec([0, 0, angles[joint]]),
            )
            found = body.data.body(child)
            assert found.xpos == pytest.approx(frames[child][0], abs=5e-4)
            off = Rotation.from_matrix(found.xmat.reshape(3, 3)).inv() * frames[child][1]
            assert off.magnitude() < 1e-3

    def test_ranges_and_speeds_are_the_makers(self) -> None:
        body = MujocoRobot().body
        for joint, _, _, *rest in self.links:
            if len(rest) > 6:
                i = body.index("test", joint)
                low, high, speed = (float(v) for v in rest[6:9])
                assert (body.low[i], body.high[i], body.speeds[i]) == (low, high, speed)

    def test_it_has_thirty_degrees_of_freedom_and_a_mouth(self) -> None:
        body = MujocoRobot().body
        moved = [name for name in body.joints if not name.startswith("mouth")]
        wheels = 2
        assert len(moved) + wheels == 30
        assert sum(name.startswith(("l_wrist", "l_shoulder", "l_elbow", "l_forearm"))
                   for name in moved) == 8  # fmt: skip
        assert body.model.nv == 3 + wheels + len(body.joints)  # 3: the base over the floor

    def test_it_stands_on_the_floor_and_is_as_tall_as_a_child(self) -> None:
        robot = MujocoRobot()
        model, data = robot.body.model, robot.body.data
        tops = data.geom_xpos[:, 2] + model.geom_rbound
        assert 1.0 < tops.max() < 1.4
        wheel = data.body("l_wheel_link").xpos[2]
        assert wheel - 0.158 == pytest.approx(0.0, abs=1e-3)
        assert robot.face[2] == pytest.approx(0.5407 + 0.37 + 0.04755, abs=1e-4)
