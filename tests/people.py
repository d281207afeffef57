"""People to test with: random tracks, rotations written out, what an error must look like."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kendon.errors import KendonError
from kendon.features import Sampler, observe
from kendon.geometry import Pose2D, Quaternion, Vec3
from kendon.observations import Observation
from kendon.person import JOINTS, PersonFrame, Track

FloatArray = NDArray[np.float64]
#: A frame this little past an interval's end still belongs to it [s].
TOLERANCE = 1e-3


def matrix(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> FloatArray:
    """Rz(yaw) Ry(pitch) Rx(roll), (3, 3), as textbooks print it."""
    ca, sa = math.cos(yaw), math.sin(yaw)
    cb, sb = math.cos(pitch), math.sin(pitch)
    cc, sc = math.cos(roll), math.sin(roll)
    return np.array(
        [
            [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
            [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
            [-sb, cb * sc, cb * cc],
        ]
    )


def quaternion(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Quaternion:
    """The same rotation as a quaternion x y z w; a head at rest in front of a robot has yaw pi."""
    x, y, z, w = Rotation.from_matrix(matrix(yaw, pitch, roll)).as_quat().tolist()
    return (x, y, z, w)


def assert_one_sentence(
    error: KendonError, path: Path, *, row: int | None = None, column: str | None = None
) -> None:
    """Assert that an error names its place and is one line, one sentence."""
    message = str(error)
    assert message.startswith(str(path))
    rest = message.removeprefix(str(path))
    assert "\n" not in rest
    assert not re.search(r"[.!?] +[A-Z]", rest), "more than one sentence"
    assert not re.search(r"Error|Traceback|np\.|array\(", rest)
    assert len(rest) < 400
    if row is not None:
        assert f"row {row}" in rest
    if column is not None:
        assert column in rest


def stream(track: Track, **options: float) -> list[Observation]:
    """What a live source would have led to."""
    sampler = Sampler(**options)  # type: ignore[arg-type]
    done = [observation for frame in track for observation in sampler.push(frame)]
    return done + sampler.advance(float(track.t[-1]) + TOLERANCE)


def assert_same(streamed: list[Observation], track: Track, **options: float) -> None:
    """To 1e-9: lists and arrays go through the same formulas, but cosines may round differently."""
    batch = observe(track, **options)  # type: ignore[arg-type]
    np.testing.assert_array_equal([o.t for o in streamed], batch.t)
    values = np.array([o.values for o in streamed])
    np.testing.assert_array_equal(np.isnan(values), np.isnan(batch.values))
    np.testing.assert_allclose(values, batch.values, rtol=1e-9, atol=1e-9)


angles = st.floats(-math.pi, math.pi)
metres = st.floats(-20, 20)
poses = st.builds(Pose2D, metres, metres, angles)
points: st.SearchStrategy[Vec3] = st.tuples(metres, metres, st.floats(0, 2.5))
directions: st.SearchStrategy[Vec3] = st.tuples(*[st.floats(-1, 1)] * 3)


@st.composite
def frames(draw: st.DrawFn) -> PersonFrame:
    """A person with everything known."""
    return PersonFrame(
        draw(st.floats(0, 1e4)),
        draw(points),
        quaternion(draw(angles), draw(angles), draw(angles)),
        (draw(points), draw(points)),
        (draw(directions), draw(directions)),
        {joint: draw(points) for joint in draw(st.sets(st.sampled_from(JOINTS)))},
        draw(st.floats(0, 5)),
        draw(st.floats(0, 1)),
        draw(st.floats(0, 1)),
        draw(st.floats(0, 1)),
        draw(poses),
    )


@st.composite
def tracks(draw: st.DrawFn, *, min_rate: float = 4.0) -> Track:
    """A person tracked badly: jitter, drops, gaps, unknown values, a robot that moves."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(3, 90))
    steps = rng.uniform(0.6, 1.4, n - 1) / draw(st.floats(min_rate, 120))
    steps *= np.where(rng.random(n - 1) < draw(st.sampled_from([0, 0.3])), rng.integers(2, 5), 1)
    if draw(st.booleans()):
        steps[rng.integers(n - 1)] += draw(st.floats(0.1, 2.5))
    t = draw(st.sampled_from([0.0, 0.0333, -3.3, 1_700_000_000.123])) + np.r_[0.0, np.cumsum(steps)]
    if digits := draw(st.sampled_from([None, 2, 3, 4])):
        t = np.unique(t.round(digits))
    assume(t[-1] - t[0] > 0.2)
    n = len(t)
    unknown = draw(st.sampled_from([0.0, 0.2, 0.8]))

    def holes(values: FloatArray) -> FloatArray:
        values[rng.random(n) < unknown] = np.nan
        return values

    head = holes(rng.uniform(-4, 4, (n, 3)))
    turn = rng.normal(size=(n, 4))
    eyes = gaze = None
    if draw(st.booleans()):
        eyes = holes(head[:, None, :] + rng.uniform(-0.05, 0.05, (n, 2, 3)))
        gaze = holes(rng.normal(size=(n, 2, 3)))
    moving = draw(st.booleans())
    return Track.build(
        t,
        head,
        head_rotation=holes(turn / np.linalg.norm(turn, axis=1, keepdims=True)),
        eyes=eyes,
        eye_gaze=gaze,
        joints={"r_wrist": holes(rng.uniform(-4, 4, (n, 3)))},
        smile=holes(rng.uniform(0, 5, n)),
        gestures=holes(rng.random((n, 3))),
        robot=rng.normal(size=(n, 3)).cumsum(axis=0) / 30 if moving else None,
        phases=rng.integers(-1, 7, n),
    )
