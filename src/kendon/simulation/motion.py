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
from kendon.simulation.limbs import (
    Curve,
    Rotation,
    Vector,
    clip,
    hang,
    pitched,
    sqrt,
    straighten,
    trigonometry,
    turn,
)
from kendon.simulation.movements import Movement
from kendon.simulation.postures import Pose, play

#: The joints of the left side and the right: shoulder, elbow, wrist and hip.
_SIDES = (JOINTS[:4], JOINTS[4:])


class Motion(NamedTuple):
    """A body over time, in the frame its places were given in."""

    joints: dict[str, FloatArray]  # name -> (N, 3) [m], in the order of kendon.person.JOINTS
    head: FloatArray  # (N, 3) [m], the face
    head_rotation: FloatArray  # (N, 4) quaternion x y z w


def look_along(yaw: FloatArray, pitch: FloatArray) -> FloatArray:
    """Heads (N, 4) that point somewhere: yaw in the ground plane, pitch down from it [rad]."""
    return np.stack(looking_along(yaw, pitch), axis=1)


def looking_along(yaw: Curve, pitch: Curve) -> Rotation:
    """One of them (or all by columns)."""
    sin, cos = trigonometry(yaw)
    sy, cy, sp, cp = sin(yaw / 2), cos(yaw / 2), sin(pitch / 2), cos(pitch / 2)
    return (-sy * sp, cy * sp, sy * cp, cy * cp)


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
    """Work out where a body's joints are over time.

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
    x, y = ground.T
    lx, ly, lz, lw = look.T
    shown = move_now(body, t, x, y, heading, (lx, ly, lz, lw), speed, steps, movements)
    joints = {name: np.stack(place, axis=1) for name, place in shown.joints.items()}
    return Motion(joints, np.stack(shown.head, axis=1), np.stack(shown.head_rotation, axis=1))


class Instant(NamedTuple):
    """A body at one instant, in the frame its places were given in (or over time, by columns)."""

    joints: dict[str, Vector]  # name -> x y z [m], in the order of kendon.person.JOINTS
    head: Vector  # [m], the face
    head_rotation: Rotation


def move_now(
    body: Body,
    t: Curve,
    x: Curve,
    y: Curve,
    heading: Curve,
    look: Rotation,
    speed: Curve,
    steps: Curve,
    movements: Iterable[Movement] = (),
) -> Instant:
    """What `move` works out at one instant, from plain numbers: some twenty times as fast.

    With arrays over time in their places the same formulas serve a whole track.
    """
    sin, cos = trigonometry(t)
    # Of a usual step, 0.7 m; none at all when standing.
    stride = sqrt(clip(speed, 0.0) * body.walk_ratio) / 0.7 * speed / (speed + 0.15)
    swing = math.pi * steps
    legs, passing = sin(swing) * stride, cos(swing) * stride  # legs: 1 = the left is forward
    still = 1 / (1 + 4 * stride)
    pose = _walking_pose(body, t, legs, stride, still)
    for movement in movements:
        play(pose, body, movement, t)
    trunk = pose.trunk

    # The pelvis: lowest with both feet on the ground, over the leg that stands (Murray 1967); it
    # moves back from under a trunk that bows.
    sway = body.sway * still
    a, b = body.phase, 2.3 * body.phase
    back = -0.06 * body.stature * sin(trunk - body.stoop)
    ahead = back + sway * (0.006 * sin(1.9 * t + b) + 0.004 * sin(4.3 * t + a))
    left = sway * (0.012 * sin(0.55 * t + a) + 0.004 * sin(2.7 * t + b)) - 0.02 * passing
    cx, sx = cos(heading), sin(heading)
    x = x + cx * ahead - sx * left
    y = y + sx * ahead + cx * left
    z = body.hip_height - 0.04 * legs * legs
    # Pelvis and shoulders turn against each other by about 4 degrees each way (Murray 1967).
    pelvis, chest = heading - 0.07 * legs, heading + 0.06 * legs
    hip_x, hip_y = -sin(pelvis) * body.half_hips, cos(pelvis) * body.half_hips
    # The chest: ahead, to the left (level) and up along the trunk.
    c, s, tilted, up_z = cos(chest), sin(chest), sin(trunk), cos(trunk)
    ahead_x, ahead_y, up_x, up_y = c * up_z, s * up_z, c * tilted, s * tilted
    torso, half = body.torso, body.half_shoulders
    mid_x, mid_y, mid_z = x + torso * up_x, y + torso * up_y, z + torso * up_z

    joints = {}
    for sign, arm, (shoulder, elbow, wrist, hip) in zip(
        (1.0, -1.0), pose.arms.values(), _SIDES, strict=True
    ):
        out_x, out_y = -sign * s, sign * c
        shoulder_x, shoulder_y = mid_x + half * out_x, mid_y + half * out_y
        joints[shoulder] = (shoulder_x, shoulder_y, mid_z)
        bent = straighten(arm, body.upper_arm, body.forearm)
        for name, (fore, out, up) in zip((elbow, wrist), bent, strict=True):
            joints[name] = (
                shoulder_x + fore * ahead_x + out * out_x + up * up_x,
                shoulder_y + fore * ahead_y + out * out_y + up * up_y,
                mid_z - fore * tilted + up * up_z,
            )
        joints[hip] = (x + sign * hip_x, y + sign * hip_y, z)
    # Heads pitch at every step, at some by more than at others, by a degree or two each way,
    # against the body's rise and fall (Hirasaki et al. 1999).
    bob = body.bob * (1 + 0.6 * sin(1.7 * steps + body.phase))
    rotation = pitched(look, pose.head + bob * (passing * passing - legs * legs))
    neck = body.neck
    face_x, face_y, face_z = turn(rotation, *body.face)
    head = (
        mid_x + neck * up_x + face_x,
        mid_y + neck * up_y + face_y,
        mid_z + neck * up_z + face_z,
    )
    return Instant(joints, head, rotation)


def _walking_pose(body: Body, t: Curve, legs: Curve, stride: Curve, still: Curve) -> Pose:
    """Arms that hang, and swing against the legs; the trunk as they carry it."""
    breath = 0.012 * body.sway * still * trigonometry(t)[0](1.4 * t + body.phase)
    arms = {}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        # Shoulders swing by 16 degrees each way, elbows bend by 25 more in front (Murray 1967).
        swing = -sign * legs * body.swing
        # From a trunk that stoops they still hang down.
        forward = body.stoop + 0.28 * swing + 2.5 * sign * breath
        bend = body.elbow + 0.22 * body.swing * stride + 0.22 * swing
        arms[side] = hang(forward, body.outward, clip(bend, 0.08))
    return Pose(body.stoop + 0.5 * breath, 0.0 * t, arms)
