"""The simulated person who steers by sight."""
