"""Make the robots of a user's own known to the tests of checks."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "robots"))
