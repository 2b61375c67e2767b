"""The filter and the plant for many states at once, with NumPy arrays in the place of numbers."""
