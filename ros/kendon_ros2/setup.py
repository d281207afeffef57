"""Lets colcon build kendon's node of ROS 2."""

from setuptools import setup

setup(
    name="kendon_ros2",
    version="0.1.0",
    packages=["kendon_ros2"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/kendon_ros2"]),
        ("share/kendon_ros2", ["package.xml"]),
    ],
    entry_points={"console_scripts": ["kendon = kendon_ros2.node:main"]},
)
