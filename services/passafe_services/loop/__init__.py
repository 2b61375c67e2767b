"""Loops that run nodes, live or in lockstep; the only package that uses Zenoh, clocks, signals and processes."""
