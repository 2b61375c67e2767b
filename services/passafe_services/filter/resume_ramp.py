"""Ramp with which the operator's command resumes after a stale stretch."""

from passafe_protocol.messages import Vector

from passafe_services.filter.dead_man import DeadManFade


class ResumeRamp:
    """Blends from the faded request before a stale stretch to the command.

    u_h(t) = s·command(t) + (1 − s)·faded(t), with t since the first command that counts again: continuous, and never
    larger than the larger of the two. s grows from 0 to 1 in the time T, the longer of resume·(1 − left) and
    fade·change, where left is the share of the operator's command that the stretch had left, and change the largest
    difference between command and faded request as a share of the larger of the two: a stretch that ends at once
    costs little, and another command comes no faster than the last one would have faded.
    """

    def __init__(self, before: DeadManFade, resume_ns: int) -> None:
        """Start without a stretch to resume from.

        Args:
            before: Receives the fade that is under way when the commands resume.
            resume_ns: Time for a command of which nothing is left, ns, at least 1.
        """
        self._before = before
        self._resume_ns = resume_ns
        self.restart()

    def restart(self) -> None:
        """Discard the ramp: a command counts in full."""
        self._began_ns = 0
        self._length_ns = 0

    def begin(self, now_ns: int, fade: DeadManFade, u_h: Vector, *, anew: bool) -> None:
        """Begin at the arrival of the first command that counts again.

        Args:
            now_ns: Monotonic time, ns.
            fade: The fade that is under way.
            u_h: The command.
            anew: Whether no command counted before.
        """
        released_ns = fade.released_ns
        left = 0.0 if anew else self.share(released_ns) * fade.left(now_ns - released_ns)
        changed = _change(u_h, fade.at(now_ns - released_ns)[0])
        self._began_ns, self._length_ns = now_ns, round(max(self._resume_ns * (1.0 - left), fade.fade_ns * changed))
        self._before.last_u_h, self._before.released_ns = fade.last_u_h, released_ns

    def share(self, now_ns: int) -> float:
        """Return s, the share of the command; 1 without a ramp.

        Args:
            now_ns: Monotonic time, ns.
        """
        elapsed_ns = max(now_ns - self._began_ns, 0)
        return 1.0 if elapsed_ns >= self._length_ns else elapsed_ns / self._length_ns

    def blend(self, share: float, now_ns: int, u_h: Vector, u_h_rate: Vector) -> tuple[Vector, Vector]:
        """Return u_h and its rate during the ramp, units of u and per second.

        Args:
            share: s < 1.
            now_ns: Monotonic time, ns.
            u_h: The command.
            u_h_rate: Its rate.
        """
        faded, faded_rate = self._before.at(now_ns - self._before.released_ns)
        rest, share_rate = 1.0 - share, 1e9 / self._length_ns
        value = tuple([share * c + rest * f for c, f in zip(u_h, faded, strict=True)])
        rate = tuple(
            [
                share * dc + rest * df + share_rate * (c - f)
                for c, dc, f, df in zip(u_h, u_h_rate, faded, faded_rate, strict=True)
            ]
        )
        return value, rate


def _change(u_h: Vector, faded: Vector) -> float:
    """Return the largest difference of two requests as a share of the larger of them, at most 1."""
    size = max(map(abs, (*u_h, *faded)))
    apart = max(abs(one - other) for one, other in zip(u_h, faded, strict=True))
    return min(apart / size, 1.0) if size else 0.0
