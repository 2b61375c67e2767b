"""Campaigns against plants that are not their model: sets, links, protections, adversaries, and the worst of each."""
