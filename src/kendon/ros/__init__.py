"""kendon as nodes of ROS: what both generations of it share, and the node for each."""
