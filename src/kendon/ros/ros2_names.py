"""Names of topics, and others for them, as ROS writes remappings: ``/odom:=/my_robot/odom``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import astuple

from kendon.errors import ParameterError
from kendon.ros.ros2_reading import FACES, ODOMETRY
from kendon.ros.ros2_settings import Ros2Topics

#: The most probable phase of whoever has been there longest, as its number (thesis 4.1.1).
STATE = "/state"
#: kendon's topics that may have another name; those of people are named by REP-155.
NAMES = (FACES, ODOMETRY, "/tf", "/tf_static", STATE, *astuple(Ros2Topics()))
#: What ROS 2 allows (design.ros2.org, topic and service names).
_NAME = re.compile(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def remappings(written: Iterable[str]) -> Mapping[str, str]:
    """The names on the network of kendon's topics that have another one there.

    Args:
        written: ``kendon's:=the network's``, each.

    Raises:
        ParameterError: one is no remapping, kendon has no such topic, or two become one.

    >>> remappings(["/odom:=/my_robot/odom", "cmd_vel:=base/cmd_vel"])
    {'/odom': '/my_robot/odom', '/cmd_vel': '/base/cmd_vel'}
    """
    names: dict[str, str] = {}
    for one in written:
        mine, mark, other = one.partition(":=")
        if not (mark and _NAME.fullmatch(mine) and _NAME.fullmatch(other)):
            raise ParameterError(
                f"{one!r} is no remapping of a topic; write it as /odom:=/my_robot/odom"
            )
        mine, other = f"/{mine.lstrip('/')}", f"/{other.lstrip('/')}"
        if mine not in NAMES:
            raise ParameterError(f"kendon has no topic {mine}; valid: {', '.join(NAMES)}")
        names[mine] = other
    taken = [names.get(name, name) for name in NAMES]
    for name in taken:
        if taken.count(name) > 1:
            raise ParameterError(f"two of kendon's topics would be {name}")
    return names
