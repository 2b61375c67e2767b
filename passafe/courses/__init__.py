"""Courses of the robot under its backup law: followed until they settle, with what they keep, and compared."""
