"""The plant process: a simulated robot with input sequences and a fail-safe of its own."""
