"""Dead-man: the fade of the operator's last request after a release of the switch or a stale command."""

from passafe_protocol.messages import Vector


class DeadManFade:
    """Fades the last request to zero along a straight line: u_h(t) = (1 − t/T)·u_h(0), t since the release.

    Attributes:
        fade_ns: T, ns.
        last_u_h: u_h(0), the last request while the switch was held, m numbers.
        released_ns: Monotonic time of the last release, ns.
    """

    def __init__(self, inputs: int, fade_ns: int) -> None:
        """Start without a request.

        Args:
            inputs: m.
            fade_ns: T, time after which the request is zero, ns.
        """
        self.fade_ns = fade_ns
        self._zero: Vector = (0.0,) * inputs
        self.restart()

    def restart(self) -> None:
        """Discard the last request."""
        self.released_ns = 0
        self.last_u_h = self._zero

    def left(self, elapsed_ns: int) -> float:
        """Return 1 − t/T, the share of the last request that is left at a time after the release, ns."""
        left_ns = self.fade_ns - max(elapsed_ns, 0)
        return left_ns / self.fade_ns if left_ns > 0 else 0.0

    def at(self, elapsed_ns: int) -> tuple[Vector, Vector]:
        """Return u_h and its rate, units of u and per second, at a time after the release, ns."""
        share = self.left(elapsed_ns)
        if share == 0.0:
            return self._zero, self._zero
        rate = -1e9 / self.fade_ns
        return tuple([share * value for value in self.last_u_h]), tuple([rate * value for value in self.last_u_h])
