"""Burst losses: the Gilbert–Elliott model."""

from collections.abc import Callable

from passafe_protocol.link_settings import LinkSettings


class GilbertElliott:
    """Markov chain with a good and a bad state, each with its own loss probability, that advances with every message.

    A message is lost with the probability of the current state; then the state changes from good to bad with
    probability p, from bad to good with r. Bad periods last 1/r messages on average, and the share p/(p + r) of all
    messages falls into one. The initial state is good. (Gilbert 1960; Elliott 1963; parameters as in netem's
    ``gemodel``.)

    Args:
        draw: Draws from [0, 1); called twice for every message.
        settings: With p, r, 1 − k and 1 − h: the four ``burst_`` settings.

    Attributes:
        settings: May be changed at any time; the state stays.
    """

    def __init__(self, draw: Callable[[], float], settings: LinkSettings) -> None:
        self._draw = draw
        self._bad = False
        self.settings = settings

    def __call__(self) -> bool:
        """Draw whether the next message is lost."""
        settings, bad = self.settings, self._bad
        lost = self._draw() < (settings.burst_loss_bad if bad else settings.burst_loss_good)
        if self._draw() < (settings.burst_leave if bad else settings.burst_enter):
            self._bad = not bad
        return lost
