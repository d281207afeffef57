"""Message definitions that ship with kendon, one folder a ROS package, as catkin lays them out.

``kendon_msgs`` is kendon's own, and a package that catkin and colcon build as it stands. The others
are the interfaces of the thesis's robot and simulator, which no package index holds: their texts
must stay equal to the originals, or the two ends refuse each other by the definitions' md5 sums.
"""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

from kendon.errors import UnknownNameError

#: The folders of definitions, by what a file in them ends in.
KINDS = ("msg", "srv", "action")


def packages() -> list[str]:
    """The ROS packages whose definitions are here, sorted.

    >>> packages()
    ['gazebo_msgs', 'kendon_msgs', 'vizzy_msgs', 'woz_dialog_msgs']
    """
    folder = files(__name__)
    return sorted(p.name for p in folder.iterdir() if p.is_dir() and not p.name.startswith("_"))


def definitions(package: str) -> dict[str, str]:
    """The texts of a ROS package's definitions by file name (``Belief.msg``), sorted.

    Raises:
        UnknownNameError: no such package is here.
    """
    if package not in packages():
        raise UnknownNameError("package of messages", package, packages())
    folder = files(__name__).joinpath(package)
    found: dict[str, str] = {}
    for kind in KINDS:
        inner: Traversable = folder.joinpath(kind)
        if inner.is_dir():
            for file in inner.iterdir():
                if file.name.endswith("." + kind):
                    found[file.name] = file.read_text(encoding="utf-8")
    return dict(sorted(found.items()))
