"""A demo as a session of runs: router and page stay, runs come and go on request."""
