"""What plant and filter must agree on to the last bit: what is in force when no input follows."""
