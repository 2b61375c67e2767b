"""Drivers of the plant: the exact model, a physics engine, or a robot's own electronics."""
