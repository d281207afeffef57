"""Where ROS 1's own Python packages are, and the messages that no package index holds.

ROS 1 is not on the Python package index. Its packages come with a sourced ROS workspace, which
puts them on the path, or with Debian and Ubuntu, whose folder also holds old copies of numpy and
others that must not get in the way of this interpreter's own: out of it, ROS's packages alone are
made importable.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import re
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from kendon._version import __version__
from kendon.errors import KendonError
from kendon.ros.messages import definitions

#: Where Debian and Ubuntu put Python packages.
DEBIAN = "/usr/lib/python3/dist-packages"
#: Debian's packages that bring all that is needed, and the modules by which one sees that.
PACKAGES = (
    "python3-rospy", "python3-rosmaster", "python3-actionlib", "python3-std-msgs",
    "python3-geometry-msgs", "python3-sensor-msgs", "python3-move-base-msgs", "python3-tf2-msgs",
    "python3-visualization-msgs",
)  # fmt: skip
MODULES = (
    "rospy", "rosmaster", "actionlib", "std_msgs.msg", "geometry_msgs.msg", "sensor_msgs.msg",
    "move_base_msgs.msg", "tf2_msgs.msg", "visualization_msgs.msg",
)  # fmt: skip
APT = f"apt-get install --no-install-recommends {' '.join(PACKAGES)}"
#: The packages of that folder that are ROS's, and those it needs which are plain Python.
_ROS = frozenset({
    "actionlib", "actionlib_msgs", "catkin", "catkin_pkg", "genmsg", "genpy", "geometry_msgs",
    "move_base_msgs", "roscpp", "rosgraph", "rosgraph_msgs", "roslib", "rosmaster", "rospy",
    "sensor_msgs", "std_msgs", "tf2_msgs", "visualization_msgs",
    "defusedxml", "distro", "pyparsing", "rospkg", "yaml",
})  # fmt: skip
_REFERENCE = re.compile(r"^\s*([a-zA-Z]\w*)/(\w+)", re.MULTILINE)


class RosMissingError(KendonError, ImportError):
    """A package of ROS 1 is not installed."""

    def __init__(self, package: str) -> None:
        super().__init__(
            f"ROS 1's Python package {package!r} is not there; source a ROS 1 workspace, or"
            f" install Debian's packages: {APT}"
        )


class _DebianFinder:
    """Finds ROS's packages in Debian's folder, and nothing else there."""

    @staticmethod
    def find_spec(
        name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The place of a package by its name, after all other finders had none."""
        del target
        if path is None and name in _ROS:
            return PathFinder.find_spec(name, [DEBIAN])
        return None


def ros_module(name: str) -> Any:
    """A module of ROS 1, such as ``rospy`` or ``std_msgs.msg``.

    Raises:
        RosMissingError: it is not installed; the message tells what to do.
    """
    if _DebianFinder not in sys.meta_path:
        sys.meta_path.append(_DebianFinder)
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise RosMissingError(error.name or name) from error


def require_ros1() -> None:
    """Make sure that all that is needed of ROS 1 is there.

    Raises:
        RosMissingError: it is not; the message tells what to do.
    """
    for name in MODULES:
        ros_module(name)


@cache
def messages(package: str) -> Any:
    """The classes of a package whose definitions ship with kendon, such as ``kendon_msgs``.

    A sourced workspace that has built the package is used as it is. Otherwise genpy, ROS's own
    generator, writes it once into a cache folder.

    Returns:
        A namespace with the messages, the parts of actions, and the services.

    Raises:
        RosMissingError: ROS is not installed.
    """
    ros_module("genpy")
    try:
        _generate(package)
        kinds = {"srv" if name.endswith(".srv") else "msg" for name in definitions(package)}
        modules = [importlib.import_module(f"{package}.{kind}") for kind in sorted(kinds)]
    except ImportError as error:
        raise RosMissingError(error.name or package) from error
    return SimpleNamespace(**{name: m for module in modules for name, m in vars(module).items()})


def _generate(package: str) -> None:
    """Make a package importable: as installed, or generated."""
    if importlib.util.find_spec(package) is not None:
        return
    texts = definitions(package)
    key = hashlib.sha256(repr((sorted(texts.items()), sys.version_info[:2])).encode()).hexdigest()
    folder = _cache_folder() / f"ros1-{package}-{key[:16]}"
    if not (folder / package / "msg" / "__init__.py").is_file():
        _write_package(package, texts, folder)
    sys.path.append(str(folder))
    importlib.invalidate_caches()


def _cache_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = Path(base) / "kendon"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:  # a home that cannot be written to, as in containers
        folder = Path(tempfile.gettempdir()) / f"kendon-{os.getuid()}-{__version__}"
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def _write_package(package: str, texts: dict[str, str], folder: Path) -> None:
    """Let genpy write a package; other processes may do the same at the same time."""
    generator = ros_module("genpy.generator")
    write_init = ros_module("genpy.generate_initpy").write_modules
    with tempfile.TemporaryDirectory(dir=folder.parent) as scratch:
        source, made = Path(scratch, "source"), Path(scratch, "made")
        files = _lay_out(package, texts, source / package)
        search = {package: [str(source / package)]}
        search.update(_dependencies(files, source))
        for kind, make in (("msg", generator.MsgGenerator()), ("srv", generator.SrvGenerator())):
            chosen = [str(file) for file in files if file.suffix == f".{kind}"]
            if not chosen:
                continue
            target = made / package / kind
            target.mkdir(parents=True)
            failed = make.generate_messages(package, chosen, str(target), search)
            if failed:
                raise ImportError(f"genpy could not generate {package}", name=package)
            write_init(str(target))
        (made / package / "__init__.py").touch()
        try:
            made.rename(folder)
        except OSError:  # another process was first
            if not (folder / package / "msg" / "__init__.py").is_file():
                raise


def _lay_out(package: str, texts: dict[str, str], folder: Path) -> list[Path]:
    """Write definitions as files for genpy, actions as the seven messages they stand for."""
    folder.mkdir(parents=True)
    files = []
    for name, text in texts.items():
        stem, _, kind = name.partition(".")
        parts = action_messages(package, stem, text) if kind == "action" else {name: text}
        for file, content in parts.items():
            files.append(folder / file)
            files[-1].write_text(content, encoding="utf-8")
    return files


def action_messages(package: str, name: str, text: str) -> dict[str, str]:
    """The seven messages that an action's definition stands for, by file name (actionlib)."""
    goal, result, feedback = re.split(r"^---[ \t]*\n", text, flags=re.MULTILINE)
    status = "std_msgs/Header header\nactionlib_msgs/GoalStatus status\n"
    return {
        f"{name}Goal.msg": goal,
        f"{name}Result.msg": result,
        f"{name}Feedback.msg": feedback,
        f"{name}ActionGoal.msg": (
            f"std_msgs/Header header\nactionlib_msgs/GoalID goal_id\n{package}/{name}Goal goal\n"
        ),
        f"{name}ActionResult.msg": f"{status}{package}/{name}Result result\n",
        f"{name}ActionFeedback.msg": f"{status}{package}/{name}Feedback feedback\n",
        f"{name}Action.msg": (
            f"{package}/{name}ActionGoal action_goal\n"
            f"{package}/{name}ActionResult action_result\n"
            f"{package}/{name}ActionFeedback action_feedback\n"
        ),
    }


def _dependencies(files: list[Path], source: Path) -> dict[str, list[str]]:
    """Write the definitions of other packages that these need, as their classes tell them."""
    own = source.name
    wanted = {m for file in files for m in _REFERENCE.findall(file.read_text(encoding="utf-8"))}
    local = {(file.parent.name, file.stem) for file in files}
    folders: dict[str, list[str]] = {}
    for package, name in sorted(wanted - local):
        # The text of a message, then after a line of "=" each message in it, headed "MSG: name".
        whole = getattr(ros_module(f"{package}.msg"), name)._full_text
        first, *others = re.split(r"^=+\nMSG: ", whole, flags=re.MULTILINE)
        for part in [f"{package}/{name}\n{first}", *others]:
            title, _, text = part.partition("\n")
            where, _, stem = title.strip().partition("/")
            folder = source / f"{own}_others" / where
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{stem}.msg").write_text(text, encoding="utf-8")
            folders[where] = [str(folder)]
    return folders
