"""Expressions taken apart: their graphs, kinks, smooth parts, relative degrees, and signs far out."""
