"""Read a run's log into pandas and ask what the filter did.

Make a log with ``passafe simulate --out runs/run.mcap``, then run ``python examples/log_to_pandas.py runs/run.mcap``.
"""

import sys
from pathlib import Path

import pandas as pd
from passafe_protocol.messages import FilterStatus, FilterTick, PlantState
from passafe_services.tools.review.run_log import RunLog

log = RunLog.read(Path(sys.argv[1]))  # decodes every message and counts what is missing
print(f"{log.identity.scenario.title}: mode {log.identity.scenario.filter.mode}")

# One row per tick of the filter. A message has a header (who, which one, when) and a body (what).
ticks = pd.DataFrame(
    {
        "plant_s": message.body.effective_plant_ns / 1e9,  # plant time at which the input takes effect
        "status": FilterStatus(message.body.status).name,
        "h": min((report.psi[0] for report in message.body.barriers), default=float("nan")),  # ψ₀ = h
        "power_margin_w": message.body.power_margin,
        "command_age_ms": message.body.command_age_ns / 1e6,
    }
    for message in log.of(FilterTick)
).set_index("plant_s")

# One row per state of the plant, where the robot really was.
states = pd.DataFrame(
    {"plant_s": message.body.plant_ns / 1e9, "x1": message.body.x[0], "x2": message.body.x[1]}
    for message in log.of(PlantState)
).set_index("plant_s")

print(ticks["status"].value_counts().to_string())
print(ticks[["h", "power_margin_w"]].describe().loc[["min", "50%", "max"]].to_string())
print(f"the tick nearest to a barrier was at {ticks['h'].idxmin():.3f} s")
print(f"the robot ended at ({states['x1'].iloc[-1]:.3f}, {states['x2'].iloc[-1]:.3f})")
