"""Numbers in memory: blocks with named parts, and linear algebra in a fixed order of operations."""
