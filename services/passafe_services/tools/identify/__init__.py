"""Estimation of parameters, noise and sets from logs."""
