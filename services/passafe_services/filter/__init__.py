"""The filter process: prediction, decision, account of every tick."""
