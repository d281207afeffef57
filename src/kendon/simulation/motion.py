"""The joints of a body that stands, walks, looks and moves: whole tracks or single frames.

What a body does is a function of time alone, so the frames of a track may be worked out together
or one by one, to the same numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from kendon.person import JOINTS, FloatArray
from kendon.simulation.body import Body
from kendon.simulation.limbs import compose, hang, pitch_quaternion, straighten, turn
from kendon.simulation.movements import Movement
from kendon.simulation.postures import Pose, play


class Motion(NamedTuple):
    """A body over time, in the frame its places were given in."""

    joints: dict[str, FloatArray]  # name -> (N, 3) [m], in the order of kendon.person.JOINTS
    head: FloatArray  # (N, 3) [m], the face
    head_rotation: FloatArray  # (N, 4) quaternion x y z w


def look_along(yaw: FloatArray, pitch: FloatArray) -> FloatArray:
    """Heads (N, 4) that point somewhere: yaw in the ground plane, pitch down from it [rad]."""
    sy, cy, sp, cp = np.sin(yaw / 2), np.cos(yaw / 2), np.sin(pitch / 2), np.cos(pitch / 2)
    return np.stack([-sy * sp, cy * sp, sy * cp, cy * cp], axis=1)


def count_steps(body: Body, t: FloatArray, speed: FloatArray) -> FloatArray:
    """Steps walked since the first of the times, at speeds [m/s]; (N,)."""
    rate = np.sqrt(np.maximum(speed, 0.0) / body.walk_ratio)
    walked = np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(t))
    return np.concatenate([[0.0], walked])


def move(
    body: Body,
    t: FloatArray,
    ground: FloatArray,
    heading: FloatArray,
    look: FloatArray,
    speed: FloatArray,
    steps: FloatArray,
    movements: Iterable[Movement] = (),
) -> Motion:
    """Work out where a body's joints are.

    Args:
        body: whose.
        t: growing times [s], (N,).
        ground: where the pelvis stands [m], (N, 2).
        heading: where the pelvis points [rad], (N,).
        look: where the head points when it does nothing else, (N, 4).
        speed: of walking [m/s], (N,); it should change as smoothly as legs let it.
        steps: walked so far, (N,); half a stride each, the left leg passing at whole even
            numbers and the right one at odd (`count_steps`).
        movements: what they do meanwhile.
    """
    # Of a usual step, 0.7 m; none at all when standing.
    stride = np.sqrt(np.maximum(speed, 0.0) * body.walk_ratio) / 0.7 * speed / (speed + 0.15)
    legs = np.sin(math.pi * steps) * stride  # 1 = the left leg is forward
    still = 1 / (1 + 4 * stride)
    pose = _walking_pose(body, t, legs, stride, still)
    for movement in movements:
        play(pose, body, movement, t)

    # The pelvis: lowest with both feet on the ground, over the leg that stands (Murray 1967); it
    # moves back from under a trunk that bows.
    sway = body.sway * still
    a, b = body.phase, 2.3 * body.phase
    back = -0.06 * body.stature * np.sin(pose.trunk - body.stoop)
    ahead = back + sway * (0.006 * np.sin(1.9 * t + b) + 0.004 * np.sin(4.3 * t + a))
    left = sway * (0.012 * np.sin(0.55 * t + a) + 0.004 * np.sin(2.7 * t + b))
    left = left - 0.02 * stride * np.cos(math.pi * steps)
    drop = 0.04 * stride**2 * (1 - np.cos(2 * math.pi * steps)) / 2
    # Pelvis and shoulders turn against each other by about 4 degrees each way (Murray 1967).
    pelvis, chest = heading - 0.07 * legs, heading + 0.06 * legs
    cx, sx = np.cos(heading), np.sin(heading)
    x = ground[:, 0] + cx * ahead - sx * left
    y = ground[:, 1] + sx * ahead + cx * left
    hips = np.array([x, y, body.hip_height - drop])

    c, s, cp, sp = np.cos(chest), np.sin(chest), np.cos(pose.trunk), np.sin(pose.trunk)

    def of_chest(
        px: FloatArray | float, py: FloatArray | float, pz: FloatArray | float
    ) -> FloatArray:
        forward = cp * px + sp * pz
        turned = [c * forward - s * py, s * forward + c * py, cp * pz - sp * px]
        return np.asarray(hips + np.array(turned))

    joints = {}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        half = sign * body.half_shoulders
        elbow, wrist = straighten(pose.arms[side], body.upper_arm, body.forearm)
        joints[f"{side}_shoulder"] = of_chest(0.0, half, body.torso)
        joints[f"{side}_elbow"] = of_chest(elbow[0], half + sign * elbow[1], elbow[2] + body.torso)
        joints[f"{side}_wrist"] = of_chest(wrist[0], half + sign * wrist[1], wrist[2] + body.torso)
        aside = sign * body.half_hips
        joints[f"{side}_hip"] = hips + np.array([-np.sin(pelvis), np.cos(pelvis), 0 * x]) * aside
    rotation = compose(look.T, pitch_quaternion(pose.head))
    head = of_chest(0.0, 0.0, body.torso + body.neck) + turn(rotation, *body.face)
    return Motion({name: joints[name].T for name in JOINTS}, head.T, rotation.T)


def _walking_pose(
    body: Body, t: FloatArray, legs: FloatArray, stride: FloatArray, still: FloatArray
) -> Pose:
    """Arms that hang, and swing against the legs; the trunk as they carry it."""
    breath = 0.012 * body.sway * still * np.sin(1.4 * t + body.phase)
    trunk = np.full_like(t, body.stoop) + 0.5 * breath
    arms = {}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        # Shoulders swing by 16 degrees each way, elbows bend by 25 more in front (Murray 1967).
        swing = -sign * legs * body.swing
        # From a trunk that stoops they still hang down.
        forward = body.stoop + 0.28 * swing + 2.5 * sign * breath
        bend = body.elbow + 0.22 * body.swing * stride + 0.22 * swing
        arms[side] = hang(forward, body.outward, np.maximum(bend, 0.08))
    return Pose(trunk, np.zeros_like(t), arms)
