"""The recorder: every message of a run into an MCAP file that survives a kill; and files that were torn."""
