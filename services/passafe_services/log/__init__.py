"""Reading and writing MCAP logs."""
