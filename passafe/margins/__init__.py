"""Margins of rows: for what happens between samples, and for all members of a family of plants."""
