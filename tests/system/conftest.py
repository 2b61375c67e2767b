"""Path of the browser of the dashboard's tests, which tests of the system share."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "dashboard"))
