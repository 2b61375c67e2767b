"""Make the small log of the tables' tests, and the robots of a user's own, known to those of the exports."""

import sys
from pathlib import Path

sys.path.extend(str(Path(__file__).parents[1] / folder) for folder in ("tables", "robots"))
