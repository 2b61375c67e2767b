"""Sweeps: many closed loops in virtual time under conditions that an experiment file describes, and their metrics."""
