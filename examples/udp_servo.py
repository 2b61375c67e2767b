"""A servo that answers datagrams, for trying the driver `udp-servo` without hardware.

It keeps the promises that a driver's robot has to keep: it stops by itself when no command comes for 50 ms, it states
when it measured by a clock of its own, and it never moves before it is asked to.

    python examples/udp_servo.py 8401 &
    passafe run plant --driver udp-servo:port=8401 …
"""

import socket
import sys
import time

from passafe_services.drivers.servo_frames import MOVE, ServoAnswer, ServoFrames

AXES = 2
SIGMA_PER_S = 1.0
PATIENCE_S = 0.05
X0 = (2.0, 2.0, -1.0, -1.0)


def serve(port: int) -> None:
    """Answer commands until Ctrl-C."""
    frames = ServoFrames(AXES)
    p, v, u = list(X0[:AXES]), [0.0] * AXES, (0.0,) * AXES
    moved_s = received_s = time.monotonic()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        bound.bind(("127.0.0.1", port))
        bound.settimeout(PATIENCE_S)
        while True:
            try:
                datagram, sender = bound.recvfrom(2048)
                command = frames.command_of(datagram)
            except TimeoutError:
                command = None  # nobody asks: it brakes by itself, whatever was asked before
            now_s = time.monotonic()
            # The joints have moved until now under what was in force, not under what has just been asked.
            elapsed_s, moved_s = now_s - moved_s, now_s
            braking = 0.0 if now_s - received_s <= PATIENCE_S else 20.0
            for i in range(AXES):
                v[i] += elapsed_s * (u[i] - (SIGMA_PER_S + braking) * v[i])
                p[i] += elapsed_s * v[i]
            if now_s - received_s > PATIENCE_S:
                u = (0.0,) * AXES
            if command is not None:
                # A question is no command: it is answered, and nothing is driven.
                received_s = now_s
                u = command.u if command.kind == MOVE else (0.0,) * AXES
                bound.sendto(frames.answer(ServoAnswer(command.number, time.monotonic_ns(), (*p, *v))), sender)


if __name__ == "__main__":
    serve(int(sys.argv[1]))
