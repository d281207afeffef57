"""kendon as a ROS 1 node, and Vizzy, Gazebo and rviz by way of ROS 1."""
