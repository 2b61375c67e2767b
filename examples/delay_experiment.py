"""Find out how much delay a scenario tolerates without the filter's prediction.

Run it with ``python examples/delay_experiment.py runs/delay``. It writes an experiment file, runs it as
``passafe experiment`` does, and reads the table of results.
"""

import subprocess
import sys
from pathlib import Path

import pandas as pd

EXPERIMENT = """
schema_version = 2
name = "delay-without-prediction"
title = "What delay does with and without prediction"
scenario = "notomista-cai-2020"
seeds = { count = 1 }              # runs of every cell; more of them make the shares mean something

[overrides]                        # values of the scenario, for all runs
duration_s = 2.0
rate_hz = 500.0

[variants]                         # every cell is run with each
predicting = { "filter.prediction" = true }
blind = { "filter.prediction" = false }

[[axes]]                           # one axis that sets two links
name = "delay_s"
keys = ["links.plant-to-filter.delay_s", "links.filter-to-plant.delay_s"]
values = [0.0, 0.1]

[criteria]                         # what is asked of every run
safe = { metric = "h_min", at_least = 0.0 }
"""

folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
file = folder / "experiment.toml"
file.write_text(EXPERIMENT, encoding="utf-8")

command = [sys.executable, "-P", "-m", "passafe_services.cli", "experiment", str(file), "--out", str(folder)]
subprocess.run([*command, "--workers", "1", "--keep", "none"], check=True)

runs = pd.read_parquet(folder / "runs.parquet")  # one row per run: variant, axes, seed, metrics, criteria
print(runs.pivot_table(index="delay_s", columns="variant", values="h_min").round(4).to_string())
