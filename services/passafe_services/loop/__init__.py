"""The only place that knows Zenoh, clocks, signals and processes."""
