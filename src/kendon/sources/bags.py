"""ROS bags, read without ROS: one track a person of ROS4HRI (REP-155), or of kendon's own faces.

Everything is placed by TF in the robot's base frame, at the stamps of the messages; when they
were received only tells whether the recorder had another clock. Time begins with the first frame
of anybody in the bag. A bag without a base is one of a camera alone: it is put on the robot
where `SourceOptions.camera` says.
"""

from __future__ import annotations

import functools
import os
from pathlib import Path

from kendon.errors import DataError
from kendon.person import Track
from kendon.sources.bag_faces import people_told, tells_of_faces
from kendon.sources.bag_people import BagOptions, BagPerson, PeopleReading, listed
from kendon.sources.base import SourceOptions, register
from kendon.sources.heads import head_stamps
from kendon.sources.recording import RecordedSource
from kendon.sources.ros4hri import HumansLog, Person
from kendon.sources.ros_bags import is_bag, read_messages


@register
class BagSource(RecordedSource):
    """One person of a ROS bag."""

    name = "bag"
    reads = "ROS bags with ROS4HRI people or faces: ROS 2 folders, .db3, .mcap, ROS 1 .bag; #ID"
    example = "recording.mcap#ID"

    @classmethod
    def recognises(cls, spec: str) -> bool:
        """A ROS bag's file or folder, or with ``#`` and the id of a person, face or body."""
        return is_bag(_split(spec)[0])

    @classmethod
    def recordings(cls, spec: str) -> list[str]:
        """Everybody in the bag, each by ``bag#id``; the bag itself where there is one person."""
        path, name = _split(spec)
        names = _names(path) if name is None else []
        return [f"{path}#{name}" for name in names] if len(names) > 1 else [spec]

    @classmethod
    def open(cls, spec: str, options: SourceOptions) -> BagSource:
        """Read the person named, or else the one who was seen most.

        Raises:
            MissingExtraError: rosbags is not installed.
            DataError: the bag is missing, torn, holds no person with a place, or none of that id.
        """
        path, name = _split(spec)
        found = read_bag(path, BagOptions(camera=options.camera), person=name)
        source = cls(found.track)
        source.notes = found.notes
        return source


def read_bag(
    path: str | Path, options: BagOptions | None = None, *, person: str | None = None
) -> BagPerson:
    """One person of a bag, in the robot's base frame, with the notes on the reading.

    Args:
        path: of a ``.bag``, ``.mcap`` or ``.db3`` file, or of a ROS 2 bag's folder.
        options: what is known of its frames.
        person: the id of the person, or of a face or body of theirs; None = who was seen most.

    Raises:
        MissingExtraError: rosbags is not installed.
        DataError: the bag is missing, torn, holds no person with a place, or none of that id.
    """
    if _is_told(Path(path)):
        return _told_person(Path(path), person)
    log, people = _people(Path(path))
    if person is None:
        chosen = max(people, key=lambda p: len(head_stamps(log.transforms, p)))
    else:
        named = [p for p in people if p.name == person] or [p for p in people if person in p.ids]
        if not named:
            names = listed([p.name for p in people])
            raise DataError(f"there is no person {person!r}; valid: {names}", file=path)
        chosen = named[0]
    found = PeopleReading(Path(path), log, people, options or BagOptions()).person(chosen)
    if person is None and len(people) > 1:
        note = _note_others(Path(path), chosen.name, [p.name for p in people])
        found = BagPerson(found.track, (note, *found.notes))
    return found


def _note_others(path: Path, chosen: str, names: list[str]) -> str:
    others = listed([name for name in names if name != chosen])
    return (
        f"{path.name} holds {len(names)} people; read is {chosen}, who is seen most. Name another"
        f" one as {path.name}#ID: {others}."
    )


def _is_told(path: Path) -> bool:
    """Whether a bag tells of people by faces or poses alone."""
    return not _read(path).people() and tells_of_faces(path)


def _names(path: Path) -> list[str]:
    """Everybody in a bag."""
    return list(people_told(path)) if _is_told(path) else [p.name for p in _read(path).people()]


def _told_person(path: Path, name: str | None) -> BagPerson:
    """Somebody of whom a bag tells by faces or poses."""
    people = people_told(path)
    if name is not None and name not in people:
        raise DataError(f"there is no person {name!r}; valid: {listed(list(people))}", file=path)
    chosen = name or max(people, key=lambda one: len(people[one].track))
    if name is None and len(people) > 1:
        found = people[chosen]
        return BagPerson(found.track, (_note_others(path, chosen, list(people)), *found.notes))
    return people[chosen]


def read_bag_people(path: str | Path, options: BagOptions | None = None) -> list[Track]:
    """Everybody in a bag, in the order in which they were first seen, with one clock.

    Raises:
        MissingExtraError: rosbags is not installed.
        DataError: the bag is missing, torn, or holds no person with a place.
    """
    if _is_told(Path(path)):
        return [person.track for person in people_told(Path(path)).values()]
    log, people = _people(Path(path))
    reading = PeopleReading(Path(path), log, people, options or BagOptions())
    return [reading.person(person).track for person in people]


def _people(path: Path) -> tuple[HumansLog, list[Person]]:
    log = _read(path)
    people = log.people()
    if people:
        return log, people
    frames = log.transforms.frames
    tracked = log.unplaced()
    if tracked:
        reason = f"{listed(tracked)} {'is' if len(tracked) == 1 else 'are'} tracked, but"
        reason += " no transform places a frame face_ID or head_ID"
    elif log.unstamped and not frames:
        reason = "its transforms have no stamps"
    else:
        reason = "ROS4HRI people have frames face_ID and gaze_ID in /tf, or head_ID and body_ID"
        reason += f"; frames in it: {listed(frames)}"
    raise DataError(f"no people in this bag: {reason}", file=path)


def _read(path: Path) -> HumansLog:
    """All that a bag tells of people; the latest ones are kept, as each person asks anew."""
    try:
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        state = tuple((file.name, file.stat().st_mtime_ns, file.stat().st_size) for file in files)
    except OSError as error:
        if not os.path.lexists(path):
            raise DataError("there is no such bag", file=path) from None
        raise DataError(f"cannot be read ({error.strerror})", file=path) from None
    return _read_once(path, state)


@functools.lru_cache(maxsize=2)
def _read_once(path: Path, state: tuple[tuple[str, int, int], ...]) -> HumansLog:
    del state  # what was read before counts no more when the files have changed
    log = HumansLog()
    for topic, received, message in read_messages(path, HumansLog.wanted):
        try:
            log.take(topic, message, received)
        except DataError as error:
            raise DataError(str(error), file=path) from None
        except (AttributeError, TypeError, ValueError):
            raise DataError(
                f"the messages of {topic} are not those of REP-155", file=path
            ) from None
    return log


def _split(spec: str) -> tuple[Path, str | None]:
    """The parts of ``path`` or ``path#id``."""
    path, mark, name = spec.rpartition("#")
    if not mark or Path(spec).exists():  # a file may well have such a name
        return Path(spec), None
    return Path(path), name
