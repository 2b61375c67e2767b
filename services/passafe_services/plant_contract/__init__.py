"""Contract between plant and filter, equal to the last bit: model, period, and fail-safe rule for missing inputs."""
