"""What plant and filter must agree on to the last bit: the model, its period, and what happens without an input."""
