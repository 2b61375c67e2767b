"""The plant process: a simulated robot with a play-out buffer and a fail-safe of its own."""
