"""The operator: who or what drives the robot, as a process of its own."""
