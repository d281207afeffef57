"""kendon in a colcon workspace."""
