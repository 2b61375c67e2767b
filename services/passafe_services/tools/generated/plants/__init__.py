"""Families of random plants, one a module."""
