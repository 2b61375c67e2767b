"""The recorder: writes every message of a run to an MCAP file that survives a kill."""
