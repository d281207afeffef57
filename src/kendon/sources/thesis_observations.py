"""The thesis's own way from two recorded people to observations (thesis 3.5.1).

Distance and speed are taken frame by frame (3.14-3.16) and gathered in groups of 0.2 s: by their
mean, as for UoL, or by their median, as for AVDIAR, whose depth has outliers. The usual path is
`kendon.features.observe`; this one is for comparing with the thesis.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from kendon.errors import ParameterError, UnknownNameError
from kendon.features import PERIOD, ROBOT_FACE
from kendon.features.gaze_of_track import head_gaze
from kendon.features.proxemics import distance, to_world
from kendon.geometry import Vec3
from kendon.observations import FEATURES, Observations
from kendon.person import FloatArray, Track

#: A distance this far from the median of the five around it is an outlier: three standard
#: deviations, estimated by the median deviation (Hampel 1974), and never less than what the
#: depth of SGBM is good for four metres away [1, m].
_SIGMAS = 3 * 1.4826
_LEAST = 0.1
_AROUND = 2
#: Stamps are rounded to milliseconds or finer in files [s].
_TOLERANCE = 1e-3


def thesis_observations(
    track: Track,
    aggregate: Literal["mean", "median"] = "median",
    *,
    robot_face: Vec3 = ROBOT_FACE,
) -> Observations:
    """The observations of a greeting as the thesis made them.

    Both take the frames after the first, which has no speed, in groups of 0.2 s.

    - ``median`` (AVDIAR): stamped with the middle of the group, from 0.1 s on; distances that
      are outliers are replaced by straight lines between their neighbours, and their speeds by
      the change of those distances.
    - ``mean`` (UoL): stamped with the end of the group; nothing is replaced.

    Speed is the thesis's (3.16): the partner's place **now** is compared with the person's
    places before and now. Gaze is that of the head (Gaze Detector 2), smile is gathered like
    distance, gestures and phases are the newest of the group. What is unknown stays unknown.
    For (3.14) to the letter, the robot must stand under the partner's head.

    Args:
        track: the person, the robot in the partner's place.
        aggregate: how the frames of a group become one value.
        robot_face: the partner's face in the robot's base frame [m].

    Raises:
        UnknownNameError: `aggregate` is neither ``mean`` nor ``median``.
        ParameterError: the track is shorter than one group.
    """
    if aggregate not in ("mean", "median"):
        raise UnknownNameError("aggregate", aggregate, ("mean", "median"))
    groups = int((track.duration + _TOLERANCE) // PERIOD)
    if groups < 1:
        raise ParameterError(
            f"{track.name or 'the track'} lasts {track.duration:.2f} s;"
            f" the first observation needs {PERIOD:g} s"
        )
    frames = np.column_stack(
        [
            distance(track.head),
            _speed(track),
            head_gaze(track.head, track.head_rotation, np.array(robot_face)),
            track.smile,
        ]
    )
    values = np.full((groups, len(FEATURES)), math.nan)
    phases = None if track.phases is None else np.full(groups, -1)
    ends = track.t[0] + PERIOD * np.arange(groups + 1)
    stops = np.searchsorted(track.t, ends + _TOLERANCE, side="right")
    for k in range(groups):
        group = slice(stops[k], stops[k + 1])
        if stops[k] == stops[k + 1]:
            continue
        for column in range(frames.shape[1]):
            known = frames[group, column]
            known = known[~np.isnan(known)]
            if len(known):
                values[k, column] = known.mean() if aggregate == "mean" else np.median(known)
        values[k, 4:] = track.gestures[stops[k + 1] - 1]
        if phases is not None and track.phases is not None:
            phases[k] = track.phases[stops[k + 1] - 1]
    if aggregate == "mean":
        return Observations(ends[1:], values, phases, track.name)
    _replace_outliers(values)
    return Observations(ends[1:] - PERIOD / 2, values, phases, track.name)


def _speed(track: Track) -> FloatArray:
    """(3.14-3.16) frame by frame, shape (T,) [m/s]; the first is unknown."""
    places = to_world(track.head, track.robot)
    robot = track.robot[1:, :2]
    before = np.linalg.norm(places[:-1] - robot, axis=1)
    now = np.linalg.norm(places[1:] - robot, axis=1)
    return np.concatenate([[math.nan], (before - now) / np.diff(track.t)])


def _replace_outliers(values: FloatArray) -> None:
    """Straight lines through outliers of the distance, and the speeds that follow; in place."""
    way = values[:, 0].copy()
    known = np.flatnonzero(~np.isnan(way))
    bad = []
    for place, k in enumerate(known):
        around = way[known[max(0, place - _AROUND) : place + _AROUND + 1]]
        middle = np.median(around)
        spread = np.median(np.abs(around - middle))
        if abs(way[k] - middle) > max(_SIGMAS * spread, _LEAST):
            bad.append(k)
    good = np.setdiff1d(known, bad)
    if not bad or not len(good):
        return
    values[bad, 0] = np.interp(bad, good, way[good])
    for k in bad:
        if k > 0:
            values[k, 1] = (values[k - 1, 0] - values[k, 0]) / PERIOD
