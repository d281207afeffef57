"""Rotations, min-jerk curves and the two-link arm, for whole movements at once.

Vectors are arrays (3, N), rotations quaternions (4, N) x y z w. An arm is worked out as if it
were the left one: y points away from the body. Mirrored in y, the same numbers are the right arm.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kendon.person import FloatArray

#: How far an elbow bends and straightens [rad]: 145 and 4 degrees (AAOS 1965 and a margin).
MOST_BENT = math.radians(145)
LEAST_BENT = math.radians(4)


class Arm(NamedTuple):
    """How an arm is held."""

    shoulder: FloatArray  # (4, N): turns a hanging arm whose elbow bends forward; w >= 0
    elbow: FloatArray  # (N,), 0 = straight [rad]


def min_jerk(x: FloatArray) -> FloatArray:
    """From 0 at x = 0 to 1 at x = 1 as smoothly as hands move (Flash & Hogan 1985).

    >>> min_jerk(np.array([-1.0, 0.0, 0.5, 1.0, 2.0])).tolist()
    [0.0, 0.0, 0.5, 1.0, 1.0]
    """
    x = np.clip(x, 0.0, 1.0)
    return x * x * x * (10 + x * (6 * x - 15))


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """The rotations that apply `b`, then `a`; (4, N)."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def pitch_quaternion(angle: FloatArray) -> FloatArray:
    """Rotations about y, which lower a face and swing a hanging arm back; (4, N)."""
    zero = np.zeros_like(angle)
    return np.array([zero, np.sin(angle / 2), zero, np.cos(angle / 2)])


def turn(rotation: FloatArray, x: FloatArray | float, z: FloatArray | float) -> FloatArray:
    """The vectors (x, 0, z) turned; (3, N)."""
    qx, qy, qz, qw = rotation
    return np.array(
        [
            (1 - 2 * (qy * qy + qz * qz)) * x + 2 * (qx * qz + qw * qy) * z,
            2 * (qx * qy + qw * qz) * x + 2 * (qy * qz - qw * qx) * z,
            2 * (qx * qz - qw * qy) * x + (1 - 2 * (qx * qx + qy * qy)) * z,
        ]
    )


def blend(a: Arm, b: Arm, weight: FloatArray) -> Arm:
    """From one way to hold an arm to another, along the shortest turn of the shoulder."""
    half = np.arccos(np.clip((a.shoulder * b.shoulder).sum(axis=0), -1.0, 1.0))
    apart = half > 1e-6
    sine = np.where(apart, np.sin(half), 1.0)
    there = np.where(apart, np.sin(weight * half) / sine, weight)
    here = np.where(apart, np.sin((1 - weight) * half) / sine, 1 - weight)
    shoulder = here * a.shoulder + there * b.shoulder
    shoulder /= np.sqrt((shoulder * shoulder).sum(axis=0))
    return Arm(shoulder, a.elbow + weight * (b.elbow - a.elbow))


def hang(forward: FloatArray, outward: FloatArray | float, elbow: FloatArray) -> Arm:
    """An arm that hangs, swung forward and held away from the body by small angles [rad]."""
    f, o = -forward / 2, np.broadcast_to(np.divide(outward, 2), np.shape(forward))
    sf, cf, so, co = np.sin(f), np.cos(f), np.sin(o), np.cos(o)
    return Arm(np.array([cf * so, sf * co, -sf * so, cf * co]), elbow)


def reach(wrist: FloatArray, pole: FloatArray, upper: float, fore: float) -> Arm:
    """The arm whose wrist is somewhere: inverse kinematics of two links.

    The elbow lies on a circle about the line from the shoulder to the wrist; of its points the
    one nearest to a direction, the pole, is taken, as animators do. A wrist out of reach is
    brought into it along that line.

    Args:
        wrist: from the shoulder [m], (3, N).
        pole: where the elbow points, (3, N) or (3, 1), not along the line to the wrist.
        upper: length of the upper arm [m].
        fore: length of the forearm [m].
    """
    square = upper * upper + fore * fore
    span = np.sqrt((wrist * wrist).sum(axis=0))
    nearest = math.sqrt(square + 2 * upper * fore * math.cos(MOST_BENT))
    farthest = math.sqrt(square + 2 * upper * fore * math.cos(LEAST_BENT))
    way = np.clip(span, nearest, farthest)
    line = wrist / span
    side = pole - (pole * line).sum(axis=0) * line
    side = side / np.sqrt((side * side).sum(axis=0))
    # The law of cosines, at the elbow and at the shoulder.
    elbow = np.arccos((way * way - square) / (2 * upper * fore))
    cosine = (way * way + upper * upper - fore * fore) / (2 * upper * way)
    sine = np.sqrt(1 - cosine * cosine)
    (lx, ly, lz), (sx, sy, sz) = line, side
    hinge = np.array([ly * sz - lz * sy, lz * sx - lx * sz, lx * sy - ly * sx])
    up = -(cosine * line + sine * side)
    return Arm(_from_axes(hinge, up), elbow)


def straighten(arm: Arm, upper: float, fore: float) -> tuple[FloatArray, FloatArray]:
    """Where an arm's elbow and wrist are from its shoulder [m], (3, N) each."""
    elbow = turn(arm.shoulder, 0.0, -upper)
    return elbow, elbow + turn(arm.shoulder, fore * np.sin(arm.elbow), -fore * np.cos(arm.elbow))


def _from_axes(y: FloatArray, z: FloatArray) -> FloatArray:
    """The rotation to a frame's y and z axes, (3, N) each; w >= 0."""
    (m01, m11, m21), (m02, m12, m22) = y, z
    m00, m10, m20 = m11 * m22 - m21 * m12, m21 * m02 - m01 * m22, m01 * m12 - m11 * m02
    # Four times each pair's product; the row of the largest component is the exact one.
    xx, yy, zz = 1 + m00 - m11 - m22, 1 - m00 + m11 - m22, 1 - m00 - m11 + m22
    ww = 1 + m00 + m11 + m22
    xy, xz, yz = m01 + m10, m02 + m20, m12 + m21
    xw, yw, zw = m21 - m12, m02 - m20, m10 - m01
    rows = np.array([[xx, xy, xz, xw], [xy, yy, yz, yw], [xz, yz, zz, zw], [xw, yw, zw, ww]])
    best = np.argmax([xx, yy, zz, ww], axis=0)
    q = rows[best, :, np.arange(len(best))].T
    return np.asarray(q * np.where(q[3] < 0, -1.0, 1.0) / np.sqrt((q * q).sum(axis=0)))
