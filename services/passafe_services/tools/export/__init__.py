"""Logs as files of other tools: CSV, Parquet, Foxglove, ROS 2."""
