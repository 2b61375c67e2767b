"""Put the state of a demo's session into words: why nothing arrives, where the session knows it."""

from typing import Any


def silence_words(session: dict[str, Any] | None) -> str:
    """Return why filter or plant may be silent; empty if the session does not know.

    Args:
        session: State of the session as the page receives it; ``None``: no demo supervises this system.
    """
    if session is None:
        return ""
    run = session["run"]
    if session["state"] == "running":
        down = [name for name, process in session["processes"].items() if process["state"] == "down"]
        return f"{' and '.join(down)} {'is' if len(down) == 1 else 'are'} down until restarted." if down else ""
    if session["state"] == "stopped":
        return f"No run is going on: {session['trouble'] or f'run {run} has ended'}. Start another one."
    return f"Run {run} is {session['state']}."
