"""Enclosures: balls that contain all values of an expression, tubes that contain all states within a period."""
