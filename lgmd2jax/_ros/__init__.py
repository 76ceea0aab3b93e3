"""A ROS 2 package around `hard.py`, from templates."""
