"""Make the small log of the tables' tests known to those of the exports."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "tables"))
