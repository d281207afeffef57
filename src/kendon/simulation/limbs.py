"""Rotations, min-jerk curves and the two-link arm, at one instant or over whole movements.

Every quantity is a plain float, for one instant, or an array (N,) over time: the same formulas
serve both, since array arithmetic on single numbers costs twenty times as much. Vectors are
tuples x y z of them, rotations quaternions x y z w. An arm is worked out as if it were the left
one: y points away from the body. Mirrored in y, the same numbers are the right arm.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

#: How far an elbow bends and straightens [rad]: 145 and 4 degrees (AAOS 1965 and a margin).
MOST_BENT = math.radians(145)
LEAST_BENT = math.radians(4)
_COS_MOST_BENT, _COS_LEAST_BENT = math.cos(MOST_BENT), math.cos(LEAST_BENT)

#: A float at one instant, or an array (N,) over time.
Curve = Any
#: A point or direction x y z, and a rotation x y z w.
Vector = tuple[Curve, Curve, Curve]
Rotation = tuple[Curve, Curve, Curve, Curve]


class Arm(NamedTuple):
    """How an arm is held."""

    shoulder: Rotation  # turns a hanging arm whose elbow bends forward; w >= 0
    elbow: Curve  # 0 = straight [rad]


def sin(x: Curve) -> Curve:
    """The sine of an angle [rad]."""
    return math.sin(x) if isinstance(x, float) else np.sin(x)


def cos(x: Curve) -> Curve:
    """The cosine of an angle [rad]."""
    return math.cos(x) if isinstance(x, float) else np.cos(x)


def trigonometry(x: Curve) -> tuple[Callable[[Curve], Curve], Callable[[Curve], Curve]]:
    """Sine and cosine for what is like `x`: for those who take many of them."""
    return (math.sin, math.cos) if isinstance(x, float) else (np.sin, np.cos)


def acos(x: Curve) -> Curve:
    """The angle of a cosine [rad]."""
    return math.acos(x) if isinstance(x, float) else np.arccos(x)


def sqrt(x: Curve) -> Curve:
    """The square root of what is not negative."""
    return math.sqrt(x) if isinstance(x, float) else np.sqrt(x)


def clip(x: Curve, least: float, most: float = math.inf) -> Curve:
    """What is nearest to `x` from `least` to `most`."""
    if isinstance(x, float):
        return least if x < least else most if x > most else x
    return np.minimum(np.maximum(x, least), most)


def min_jerk(x: Curve) -> Curve:
    """From 0 at x = 0 to 1 at x = 1 as smoothly as hands move (Flash & Hogan 1985).

    >>> [min_jerk(x) for x in (-1.0, 0.0, 0.5, 1.0, 2.0)]
    [0.0, 0.0, 0.5, 1.0, 1.0]
    """
    if isinstance(x, float):  # as `clip`, which costs as much again as the rest
        if not 0.0 < x < 1.0:
            return 0.0 if x <= 0.0 else 1.0 if x >= 1.0 else x
    else:
        x = np.minimum(np.maximum(x, 0.0), 1.0)
    return x * x * x * (10 + x * (6 * x - 15))


def pitched(rotation: Rotation, angle: Curve) -> Rotation:
    """A rotation after one about y, which lowers a face [rad]."""
    x, y, z, w = rotation
    s, c = sin(angle / 2), cos(angle / 2)
    return (x * c - z * s, w * s + y * c, z * c + x * s, w * c - y * s)


def turn(rotation: Rotation, x: Curve, z: Curve) -> Vector:
    """The vector (x, 0, z) turned."""
    qx, qy, qz, qw = rotation
    return (
        (1 - 2 * (qy * qy + qz * qz)) * x + 2 * (qx * qz + qw * qy) * z,
        2 * (qx * qy + qw * qz) * x + 2 * (qy * qz - qw * qx) * z,
        2 * (qx * qz - qw * qy) * x + (1 - 2 * (qx * qx + qy * qy)) * z,
    )


def blend(a: Arm, b: Arm, weight: Curve) -> Arm:
    """From one way to hold an arm to another, along the shortest turn of the shoulder."""
    ax, ay, az, aw = a.shoulder
    bx, by, bz, bw = b.shoulder
    here, there = _slerp(acos(clip(ax * bx + ay * by + az * bz + aw * bw, -1.0, 1.0)), weight)
    x, y = here * ax + there * bx, here * ay + there * by
    z, w = here * az + there * bz, here * aw + there * bw
    size = sqrt(x * x + y * y + z * z + w * w)
    shoulder = (x / size, y / size, z / size, w / size)
    return Arm(shoulder, a.elbow + weight * (b.elbow - a.elbow))


def _slerp(half: Curve, weight: Curve) -> tuple[Curve, Curve]:
    """The shares of two rotations half of whose difference is `half` [rad]."""
    if isinstance(half, float):
        if half <= 1e-6:
            return 1 - weight, weight
        sine = math.sin(half)
        return math.sin((1 - weight) * half) / sine, math.sin(weight * half) / sine
    apart = half > 1e-6
    sines = np.where(apart, np.sin(half), 1.0)
    there = np.where(apart, np.sin(weight * half) / sines, weight)
    return np.where(apart, np.sin((1 - weight) * half) / sines, 1 - weight), there


def hang(forward: Curve, outward: float, elbow: Curve) -> Arm:
    """An arm that hangs, swung forward and held away from the body by small angles [rad]."""
    sin, cos = trigonometry(forward)
    sf, cf = sin(-forward / 2), cos(forward / 2)
    so, co = math.sin(outward / 2), math.cos(outward / 2)
    return Arm((cf * so, sf * co, -sf * so, cf * co), elbow)


def reach(wrist: Vector, pole: Vector, upper: float, fore: float) -> Arm:
    """The arm whose wrist is somewhere: inverse kinematics of two links.

    The elbow lies on a circle about the line from the shoulder to the wrist; of its points the
    one nearest to a direction, the pole, is taken, as animators do. A wrist out of reach is
    brought into it along that line.

    Args:
        wrist: from the shoulder [m].
        pole: where the elbow points, not along the line to the wrist.
        upper: length of the upper arm [m].
        fore: length of the forearm [m].
    """
    square = upper * upper + fore * fore
    wx, wy, wz = wrist
    px, py, pz = pole
    span = sqrt(wx * wx + wy * wy + wz * wz)
    nearest = math.sqrt(square + 2 * upper * fore * _COS_MOST_BENT)
    farthest = math.sqrt(square + 2 * upper * fore * _COS_LEAST_BENT)
    way = clip(span, nearest, farthest)
    lx, ly, lz = wx / span, wy / span, wz / span
    along = px * lx + py * ly + pz * lz
    sx, sy, sz = px - along * lx, py - along * ly, pz - along * lz
    off = sqrt(sx * sx + sy * sy + sz * sz)
    sx, sy, sz = sx / off, sy / off, sz / off
    # The law of cosines, at the elbow and at the shoulder.
    elbow = acos((way * way - square) / (2 * upper * fore))
    cosine = (way * way + upper * upper - fore * fore) / (2 * upper * way)
    sine = sqrt(1 - cosine * cosine)
    hinge = (ly * sz - lz * sy, lz * sx - lx * sz, lx * sy - ly * sx)
    up = (-(cosine * lx + sine * sx), -(cosine * ly + sine * sy), -(cosine * lz + sine * sz))
    return Arm(_from_axes(hinge, up), elbow)


def straighten(arm: Arm, upper: float, fore: float) -> tuple[Vector, Vector]:
    """Where an arm's elbow and wrist are from its shoulder [m]."""
    sin, cos = trigonometry(arm.elbow)
    qx, qy, qz, qw = arm.shoulder
    # A hanging arm points along -z, a forearm that bends comes up toward x.
    down_x, down_y = -2 * (qx * qz + qw * qy), -2 * (qy * qz - qw * qx)
    down_z = 2 * (qx * qx + qy * qy) - 1
    up_x, up_y, up_z = 1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz), 2 * (qx * qz - qw * qy)
    along, bent = upper + fore * cos(arm.elbow), fore * sin(arm.elbow)
    return (upper * down_x, upper * down_y, upper * down_z), (
        along * down_x + bent * up_x,
        along * down_y + bent * up_y,
        along * down_z + bent * up_z,
    )


def _from_axes(y: Vector, z: Vector) -> Rotation:
    """The rotation to a frame's y and z axes; w >= 0."""
    (m01, m11, m21), (m02, m12, m22) = y, z
    m00, m10, m20 = m11 * m22 - m21 * m12, m21 * m02 - m01 * m22, m01 * m12 - m11 * m02
    # Four times each pair's product; the row of the largest component is the exact one.
    xx, yy, zz = 1 + m00 - m11 - m22, 1 - m00 + m11 - m22, 1 - m00 - m11 + m22
    ww = 1 + m00 + m11 + m22
    xy, xz, yz = m01 + m10, m02 + m20, m12 + m21
    xw, yw, zw = m21 - m12, m02 - m20, m10 - m01
    rows = ((xx, xy, xz, xw), (xy, yy, yz, yw), (xz, yz, zz, zw), (xw, yw, zw, ww))
    if isinstance(ww, float):
        largest = (xx, yy, zz, ww)
        qx, qy, qz, qw = rows[largest.index(max(largest))]
        size = math.copysign(math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw), qw)
        return (qx / size, qy / size, qz / size, qw / size)
    best = np.argmax([xx, yy, zz, ww], axis=0)
    q = np.array(rows)[best, :, np.arange(len(best))].T
    q = q * np.where(q[3] < 0, -1.0, 1.0) / np.sqrt((q * q).sum(axis=0))
    return (q[0], q[1], q[2], q[3])
