"""The operator process: a script, a person or a simulated person that commands the robot."""
