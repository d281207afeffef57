"""The connection to a ROS 1 master: found, kept, and made again when the master comes back."""

from __future__ import annotations

import logging
import os
import socket
import time
import xmlrpc.client
from collections.abc import Sequence
from http.client import HTTPException
from urllib.parse import urlparse

from kendon.errors import DataError, KendonError, ParameterError
from kendon.ros.ros1.environment import ros_module

#: How long a master may take to answer at the start [s].
_ANSWERS = 3.0
#: How often queues are looked into [s].
_LOOKED = 0.002


class MasterMissingError(KendonError):
    """No ROS 1 master answers."""

    def __init__(self, uri: str) -> None:
        super().__init__(
            f"no ROS 1 master answers at {uri} (ROS_MASTER_URI); start one with `roscore`, or on"
            " Debian with `rosmaster --core`"
        )


def start_node(name: str, remappings: Sequence[str] = ()) -> None:
    """Make this process a node; once a process.

    The logging of the caller stays as it is, and so do its signal handlers.

    Args:
        name: of the node, unless a remapping ``__name:=`` gives another one.
        remappings: as ROS takes them on a command line (``/faces:=/camera/faces``).

    Raises:
        RosMissingError: ROS 1 is not installed.
        MasterMissingError: no master answers.
        ParameterError: a remapping is none.
    """
    rospy = ros_module("rospy")
    for text in remappings:
        source, mark, _ = text.partition(":=")
        if not (mark and source):
            raise ParameterError(
                f"{text!r} is neither an option nor a remapping like /faces:=/camera/faces, a"
                " parameter like _model:=kendon, or __name:= and __ns:="
            )
    _find_master()
    root = logging.getLogger()
    handlers, level = list(root.handlers), root.level
    try:
        rospy.init_node(name, argv=["kendon", *remappings], disable_signals=True)
    except (ValueError, rospy.ROSException) as error:
        raise ParameterError(f"ROS refuses this node: {error}") from None
    finally:
        # init_node configures logging for the whole process.
        for added in set(root.handlers) - set(handlers):
            added.close()
        root.handlers[:], root.level = handlers, level


def _find_master() -> None:
    """Make sure that there is a master, and that others can reach this node.

    Raises:
        MasterMissingError: there is none.
    """
    uri = os.environ.setdefault("ROS_MASTER_URI", "http://localhost:11311")
    place = urlparse(uri)
    try:
        with socket.create_connection((place.hostname, place.port or 11311), _ANSWERS) as link:
            own_address = link.getsockname()[0]
        ros_module("rosgraph").Master("/kendon").getPid()
    except (OSError, ValueError):
        raise MasterMissingError(uri) from None
    except ros_module("rosgraph").MasterException:
        raise MasterMissingError(uri) from None
    if not (os.environ.get("ROS_IP") or os.environ.get("ROS_HOSTNAME")):
        try:
            socket.gethostbyname(socket.gethostname())
        except OSError:
            # Nodes would be told a name that nobody can resolve, and no data would ever come.
            os.environ["ROS_IP"] = own_address


def require_type(topic: str, wanted: str, advice: str) -> None:
    """Refuse a topic that carries messages of another type, as no data would ever come.

    Args:
        topic: resolved, with the slash before it.
        wanted: the type that is needed.
        advice: what the user can do.

    Raises:
        DataError: it carries messages of another type.
    """
    rospy = ros_module("rospy")
    for name, kind in ros_module("rosgraph").Master(rospy.get_name()).getTopicTypes():
        if name == topic and kind not in (wanted, "*"):
            raise DataError(f"it carries {kind}, not {wanted}; {advice}", file=topic)


def flush(seconds: float) -> list[str]:
    """Wait until all that this node has published is on its way.

    ROS 1 publishes by a thread a subscriber, from queues that it drops at its end. What has left
    them is the operating system's to deliver, whatever becomes of this process.

    Args:
        seconds: how long a subscriber may hold up what is meant for it.

    Returns:
        The topics of which something could not leave, sorted.
    """
    deadline = time.monotonic() + seconds
    manager = ros_module("rospy.topics").get_topic_manager()
    with manager.lock:
        links = [
            (impl.resolved_name, c) for impl in manager.pubs.values() for c in impl.connections
        ]
    stuck = set()
    # Twice: with the queue empty, its last messages may still be in the thread's hands. It takes
    # the mark, which is no byte at all, only when they have left.
    for mark in (False, True):
        for topic, link in links:
            queue = vars(link).get("_queue")  # only rospy's QueuedConnection has one
            if queue is None or topic in stuck:
                continue
            try:
                if mark:
                    link.write_data(b"")
                while vars(link)["_queue"] and not link.done:
                    if time.monotonic() >= deadline:
                        stuck.add(topic)
                        break
                    time.sleep(_LOOKED)
            except Exception:  # rospy raises here whatever went wrong with an earlier message
                stuck.add(topic)
    return sorted(stuck)


def master_errors() -> tuple[type[Exception], ...]:
    """What calls of a master raise that has gone, is going, or refuses."""
    return (OSError, HTTPException, xmlrpc.client.Error, ros_module("rosgraph").MasterException)


class MasterWatch:
    """Registers the node anew with a master that was started again.

    A ROS 1 node registers once: to a new master it would be a stranger, and nobody who starts
    later would find it. Make this before what is to be registered: a master that comes in between
    knows only the rest.
    """

    def __init__(self) -> None:
        self.lost = False  # whether the master does not answer
        rospy = ros_module("rospy")
        self._name: str = rospy.get_name()
        self._master = ros_module("rosgraph").Master(self._name)
        self._uri: str = rospy.get_node_uri()
        self._pid: int = self._master.getPid()

    def check(self) -> str:
        """See to it; a sentence if something has changed, else ""."""
        try:
            pid = self._master.getPid()
            known = pid == self._pid and self._knows()
            if not known:
                self._register()
                self._pid = pid
        except master_errors():
            if self.lost:
                return ""
            self.lost = True
            return "The ROS master does not answer; topics that are connected go on."
        if self.lost or not known:
            self.lost = False
            return (
                "The ROS master is back." if known else "The node is registered with a new master."
            )
        return ""

    def _knows(self) -> bool:
        try:
            return bool(self._master.lookupNode(self._name) == self._uri)
        except ros_module("rosgraph").MasterException:
            return False

    def _register(self) -> None:
        manager = ros_module("rospy.topics").get_topic_manager()
        node = xmlrpc.client.ServerProxy(self._uri)
        for topic, kind in manager.get_publications():
            self._master.registerPublisher(topic, kind, self._uri)
        for topic, kind in manager.get_subscriptions():
            publishers = self._master.registerSubscriber(topic, kind, self._uri)
            # What a master does itself when publishers come and go.
            node.publisherUpdate("/master", topic, publishers)
        services = ros_module("rospy.impl.registration").get_service_manager()
        for name, uri in services.get_services():
            self._master.registerService(name, uri, self._uri)
