"""Arguments as callers write them: numbers, ranges, limits of axes, expressions; else one typed error."""
