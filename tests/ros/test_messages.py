"""The definitions: two generators that know nothing of each other agree on every md5 sum."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from ros.ros1_world import require_ros1

from kendon.errors import UnknownNameError
from kendon.ros.messages import definitions, packages
from kendon.ros.ros1 import environment


def test_packages_are_known_by_their_names() -> None:
    assert set(definitions("kendon_msgs")) == {
        "Belief.msg", "FaceExtraction.msg", "Observation.msg",
    }  # fmt: skip
    with pytest.raises(UnknownNameError, match="did you mean 'kendon_msgs'"):
        definitions("kendon_msg")


@pytest.mark.parametrize("package", packages())
def test_genpy_and_rosbags_agree_on_every_sum(package: str) -> None:
    require_ros1()
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    made = environment.messages(package)
    for file, text in definitions(package).items():
        stem, _, kind = file.partition(".")
        if kind == "srv":
            continue  # rosbags knows no services
        texts = {file: text} if kind == "msg" else environment.action_messages(package, stem, text)
        types: dict[str, Any] = {}
        for name, content in texts.items():
            types |= typesys.get_types_from_msg(content, f"{package}/msg/{name[:-4]}")
        store.register(types)
        for name in texts:
            _, expected = store.generate_msgdef(f"{package}/msg/{name[:-4]}", ros_version=1)
            assert getattr(made, name[:-4])._md5sum == expected, name


def test_the_interfaces_of_others_have_the_sums_of_their_originals() -> None:
    require_ros1()
    assert environment.messages("vizzy_msgs").GazeGoal._md5sum == "a1b8bf39eac0adbf0be2f97a6f149676"
    gazebo = environment.messages("gazebo_msgs")
    assert gazebo.ModelState._md5sum == "9330fd35f2fcd82d457e54bd54e10593"
    assert gazebo.SetModelState._md5sum == "5b3ab0281d4f5445def017e3a2e4a07b"


def test_ros_2_takes_the_same_files() -> None:
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    for file, text in definitions("kendon_msgs").items():
        name = f"kendon_msgs/msg/{file[:-4]}"
        store.register(typesys.get_types_from_msg(text, name))
        assert name in store.fielddefs


def test_the_package_builds_every_definition() -> None:
    cmake = Path(environment.__file__).parents[1] / "messages" / "kendon_msgs" / "CMakeLists.txt"
    text = cmake.read_text(encoding="utf-8")
    for file in definitions("kendon_msgs"):
        assert text.count(file) == 2, f"{file}: once for catkin, once for colcon"
