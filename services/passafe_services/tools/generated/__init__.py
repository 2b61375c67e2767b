"""Systems from a seed: designs that nobody wrote, their closed loops, and the worst of each family."""
