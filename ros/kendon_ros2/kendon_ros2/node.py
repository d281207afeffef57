"""The executable: all of it is in the package kendon, which pip installs."""

from kendon.ros.rclpy_node import main

if __name__ == "__main__":
    main()
