"""Put into words what has to be said beside the metrics of a what-if."""

from passafe_services.tools.what_if.human_fit import HumanFit
from passafe_services.tools.what_if.what_if import WhatIf


def notes_of(result: WhatIf, fit: HumanFit | None = None) -> list[tuple[str, str]]:
    """Return what has to be said beside the metrics of a what-if: by its subject, in words.

    Args:
        result: The what-if.
        fit: The fit of the person who drove, if one was made.
    """
    first, motion = result.first_difference, result.first_motion
    notes = [
        ("changed", "; ".join(result.changes) or "nothing in the scenario"),
        ("operator", result.operator),
        ("links", result.links),
    ]
    notes += [("fit", fit.text)] if fit is not None else []
    notes += [("doubt", doubt) for doubt in result.doubts]
    if first is None:
        same = result.exactness.identical
        notes.append(
            ("exact", f"all {same['tick']} ticks and {same['state']} states are those of the log to the last bit")
        )
        return notes
    notes.append(("first", f"{first.text} ({first.at_s:.3f} s after the start): {first.cause}"))
    if motion is not None:
        notes.append(("moves", f"robot elsewhere from plant time {motion.plant_s:.3f} s on: {motion.text}"))
    return notes
