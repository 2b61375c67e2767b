"""Path of the demo's stand-in, which the fault campaign shares with the tests of the system."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "system"))
