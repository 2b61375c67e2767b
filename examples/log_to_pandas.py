"""Read a run's log into pandas and ask what the filter did.

Make a log with ``passafe simulate --out runs/run.mcap``, then run ``python examples/log_to_pandas.py runs/run.mcap``.
"""

import sys

import passafe.log

run = passafe.log.read(sys.argv[1], topics=("tick", "state", "scenario"))  # every message, decoded and checked
if run.scenario is not None:
    print(f"{run.scenario.title}: mode {run.scenario.filter.mode}")

# One row per tick of the filter. `plant_s` is the plant time at which its input takes effect.
ticks = run.ticks.pandas().set_index("plant_s")
h = ticks.filter(regex="^barrier_.*_psi_0$").min(axis=1)  # ψ₀ = h of the nearest barrier
ages_ms = ticks["command_age_ns"] / 1e6

# One row per state of the plant, where the robot really was. A table is a NumPy array for each column, too.
places = run.states.matrix("x")[:, :2]

print(ticks["status"].value_counts().to_string())
print(ticks.assign(h=h)[["h", "power_margin"]].describe().loc[["min", "50%", "max"]].to_string())
print(f"oldest command: {ages_ms.max():.1f} ms; units: {run.ticks.units['power_margin']}, {run.states.units['x_1']}")
print(f"the tick nearest to a barrier was at {h.idxmin():.3f} s")
print(f"the robot ended at ({places[-1, 0]:.3f}, {places[-1, 1]:.3f})")
