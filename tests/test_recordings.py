"""Recordings of ROS 1 and ROS 2 that cannot be finished: one sentence, and all else goes on."""

from __future__ import annotations

import gc
import random
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rosbags", reason="the extra 'bags' is not installed")
from ros2.wire import World

from kendon.errors import DataError
from kendon.models import load_model
from kendon.ros.recording import Recording
from kendon.ros.ros1.record import BagRecorder, RawMessage
from kendon.ros.ros2_node import Ros2Node
from kendon.ros.ros2_record import Recorder
from kendon.ros.ros2_types import STRING, build, type_store
from kendon.sources.ros_bags import read_messages

resource = pytest.importorskip("resource", reason="a limit for files is Unix's")
Write = Callable[[str], None]
TEXT = "992ce8a1687cec8c8bd883ec73ca41d1"  # the md5 sum of std_msgs/String, as ROS 1 gives it


def ros1(path: Path) -> tuple[Recording, Write]:
    recorder = BagRecorder(path.with_suffix(".bag"))

    def write(text: str) -> None:
        data = len(text).to_bytes(4, "little") + text.encode()
        raw = RawMessage("std_msgs/String", TEXT, "string data\n", data)
        recorder.write("/state", raw, 7)

    return recorder, write


def ros2(path: Path) -> tuple[Recording, Write]:
    recorder = Recorder(path.with_suffix(".mcap"))

    def write(text: str) -> None:
        raw = type_store().serialize_cdr(build(STRING, {"data": text}), STRING)
        recorder.write("/state", STRING, 7, bytes(raw))

    return recorder, write


@contextmanager
def full_after(size: int) -> Iterator[None]:
    """As if no file could grow beyond a size [bytes]."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def noise(size: int) -> str:
    """A text that no compression makes much smaller."""
    return random.Random(size).randbytes(size // 2).hex()


@pytest.fixture(params=[ros1, ros2])
def recording(request: Any, tmp_path: Path) -> tuple[Recording, Write]:
    (tmp_path / "hall").mkdir()
    made: tuple[Recording, Write] = request.param(tmp_path / "hall" / "greeting")
    return made


def test_a_whole_recording_is_read_again(
    recording: tuple[Recording, Write], tmp_path: Path
) -> None:
    recorder, write = recording
    for text in ("1", "2"):
        write(text)
    recorder.close()
    recorder.close()
    (path,) = (tmp_path / "hall").iterdir()
    assert [message.data for _, _, message in read_messages(path, lambda _: True)] == ["1", "2"]


def test_a_disk_that_gets_full_ends_the_recording_alone(
    recording: tuple[Recording, Write], tmp_path: Path
) -> None:
    recorder, write = recording
    with full_after(500_000):
        for _ in range(40):
            write(noise(100_000))  # no error, however often
        ended = recorder.trouble
        count = recorder.count
        write("after the end")
        with pytest.raises(DataError) as error:
            recorder.close()
    assert "greeting" in ended
    assert "the recording has ended (File too large)" in ended
    assert recorder.count == count < 40
    assert str(error.value).startswith(f"{ended}; what was written until then is in ")
    left = Path(str(error.value).split(" is in ")[1].removesuffix(", without an end"))
    assert left.stat().st_size > 400_000
    recorder.close()  # nothing to do
    gc.collect()  # no file is left open


def test_a_disk_that_is_full_at_the_end_is_told_in_one_sentence(
    recording: tuple[Recording, Write], tmp_path: Path
) -> None:
    recorder, write = recording
    write(noise(100_000))
    assert not recorder.trouble
    with (
        full_after(5_000),
        pytest.raises(DataError, match=r"the recording has ended \(File too large\)"),
    ):
        recorder.close()
    gc.collect()


def test_a_folder_that_has_gone_is_told_in_one_sentence(
    recording: tuple[Recording, Write], tmp_path: Path
) -> None:
    recorder, write = recording
    write("4")
    shutil.rmtree(tmp_path / "hall")
    with pytest.raises(DataError, match=r"No such file or directory.*nothing of it is left"):
        recorder.close()
    assert list(tmp_path.iterdir()) == []
    gc.collect()


def test_a_node_greets_on_though_it_cannot_record(tmp_path: Path) -> None:
    world = World()
    recorder, write = ros2(tmp_path / "greeting")
    assert isinstance(recorder, Recorder)
    node = Ros2Node(world.wire, load_model(), recorder=recorder, clock=world.wire.clock)
    running = node.run()
    for _ in range(10):
        next(running)
    with full_after(0):
        for _ in range(400):  # until rosbags writes what it has gathered
            write(noise(10_000))
        for _ in range(10):
            next(running)
        assert len([note for note in node.notes if "the recording has ended" in note]) == 1
        frames = node.reader.frames
        for _ in range(10):
            next(running)
        assert node.reader.frames > frames
        with pytest.raises(DataError, match="the recording has ended"):
            running.close()
    assert world.wire.closed
