"""The plant process: a robot behind its driver, with input sequences and a fail-safe of its own."""
