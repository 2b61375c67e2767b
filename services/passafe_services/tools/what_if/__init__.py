"""Re-runs of logs in closed loop, with something changed."""
