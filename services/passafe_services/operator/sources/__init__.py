"""Sources of commands: scripts, recordings, disturbances, adversaries."""
