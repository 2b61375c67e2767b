"""Kinds of barriers, one a file: the keys of a scenario file, h, its unit, and the outline that pictures show.

Filter, review, report and page evaluate the h that the kind's file returns. ``registry.py`` lists the kinds.
"""
